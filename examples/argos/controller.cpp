#include "controller.h"

#include <cmath>
#include <stdexcept>

#include <argos3/core/simulator/physics_engine/physics_engine.h>
#include <argos3/core/utility/configuration/argos_configuration.h>
#include <argos3/core/utility/math/vector2.h>

using namespace argos;

namespace {

const Real WHEEL_DISTANCE = 0.14; /* metres */

/* A body turns away from what is at most this far to the left or right of its way. */
const CRadians AHEAD = CRadians::PI_OVER_TWO;

/* Least sum of the 24 proximity readings, as a vector, that counts as an obstacle. */
const Real OBSTACLE = 0.1;

double DrawUniform(void* pt_random) {
   return static_cast<CRandom::CRNG*>(pt_random)->Uniform(CRange<Real>(0.0, 1.0));
}

}

CFeasibeeController::~CFeasibeeController() {
   mind_free(m_ptMind);
}

void CFeasibeeController::Init(TConfigurationNode& t_node) {
   m_pcWheels = GetActuator<CCI_DifferentialSteeringActuator>("differential_steering");
   m_pcRadioOut = GetActuator<CCI_RangeAndBearingActuator>("range_and_bearing");
   m_pcRadioIn = GetSensor<CCI_RangeAndBearingSensor>("range_and_bearing");
   if(HasSensor("footbot_proximity")) {
      m_pcProximity = GetSensor<CCI_FootBotProximitySensor>("footbot_proximity");
   }
   m_pcRandom = CRandom::CreateRNG("argos");
   TConfigurationNode& tWalk = GetNode(t_node, "walk");
   GetNodeAttribute(tWalk, "ticks_per_step", m_unTicksPerStep);
   GetNodeAttribute(tWalk, "metres_per_step", m_fSpeed);
   GetNodeAttribute(tWalk, "mean_run", m_fMeanRun);
   GetNodeAttribute(GetNode(t_node, "radio"), "loss", m_fLoss);
   m_fTick = CPhysicsEngine::GetSimulationClockTick();
   m_unId = static_cast<UInt16>(std::stoul(GetId().substr(GetId().find_last_not_of("0123456789") + 1)));
   ReadDecision(GetNode(t_node, "decision"));
   Reset();
}

void CFeasibeeController::ReadDecision(TConfigurationNode& t_node) {
   GetNodeAttribute(t_node, "strategy", m_strStrategy);
   m_tSettings.strategy = m_strStrategy.c_str();
   GetNodeAttribute(t_node, "exploration", m_tSettings.exploration);
   GetNodeAttribute(t_node, "gain", m_tSettings.gain);
   GetNodeAttribute(t_node, "id_bits", m_tSettings.id_bits);
   GetNodeAttribute(t_node, "dissemination_floor", m_tSettings.dissemination_floor);
   GetNodeAttribute(t_node, "quality_floor", m_tSettings.quality_floor);
   GetNodeAttribute(t_node, "listens_for", m_tSettings.listens_for);
   GetNodeAttribute(t_node, "inbox_size", m_tSettings.inbox_size);
   GetNodeAttribute(t_node, "every_message", m_tSettings.every_message);
   GetNodeAttribute(t_node, "own_vote", m_tSettings.own_vote);
   GetNodeAttribute(t_node, "random_ties", m_tSettings.random_ties);
   GetNodeAttribute(t_node, "first_sight", m_tSettings.first_sight);
   GetNodeAttributeOrDefault(t_node, "declare_rounds", m_tSettings.declare_rounds, 0);
   GetNodeAttributeOrDefault(t_node, "declare_heard", m_tSettings.declare_heard, 0);
   GetNodeAttributeOrDefault(t_node, "declare_quorum", m_tSettings.declare_quorum, 1.0);
   GetNodeAttributeOrDefault(t_node, "k", m_tSettings.k, 1);
   GetNodeAttributeOrDefault(t_node, "credence", m_tSettings.credence, 0.0);
   GetNodeAttributeOrDefault(t_node, "positive_feedback", m_tSettings.positive_feedback, false);
}

void CFeasibeeController::Reset() {
   m_pcRandom->Reset();
   mind_free(m_ptMind);
   m_ptMind = mind_new(&m_tSettings, m_unId, DrawUniform, m_pcRandom);
   if(m_ptMind == nullptr) {
      THROW_ARGOSEXCEPTION("strategy=\"" << m_strStrategy << "\": mind.c has no such strategy");
   }
   m_cMessage = CByteArray(MIND_MESSAGE_BYTES);
   m_vecReceived.clear();
   m_unTick = 0;
   m_cTurnLeft = CRadians::ZERO;
   m_bBumped = false;
   DrawRun();
   Drive(m_pcProximity == nullptr ? m_fSpeed / m_fTick : m_fSpeed);
}

void CFeasibeeController::See(int n_robots, int n_tasks) {
   m_nRobotsSeen = n_robots;
   m_nTasksSeen = n_tasks;
}

void CFeasibeeController::Bump() {
   m_bBumped = true;
}

void CFeasibeeController::Receive(const CByteArray& c_message) {
   m_vecReceived.push_back(c_message);
}

void CFeasibeeController::ControlStep() {
   if(IsLastTick()) {
      Decide();
   }
   if(m_pcProximity == nullptr) {
      WalkAsPoint();
   }
   else {
      WalkAsBody();
   }
   m_unTick = (m_unTick + 1) % m_unTicksPerStep;
}

/* The end of a step: what is seen and heard, the decision, and the message of the next step. */
void CFeasibeeController::Decide() {
   mind_see(m_ptMind, m_nRobotsSeen, m_nTasksSeen);
   for(const auto& sPacket : m_pcRadioIn->GetReadings()) {
      m_vecReceived.push_back(sPacket.Data);
   }
   for(const CByteArray& cMessage : m_vecReceived) {
      if(m_fLoss == 0.0 || !m_pcRandom->Bernoulli(m_fLoss)) {
         mind_hear(m_ptMind, cMessage.ToCArray(), cMessage.Size());
      }
   }
   m_vecReceived.clear();
   mind_end_step(m_ptMind);
   UInt8 punBytes[MIND_MESSAGE_BYTES];
   mind_say(m_ptMind, punBytes);
   m_cMessage = CByteArray(punBytes, MIND_MESSAGE_BYTES);
   m_pcRadioOut->SetData(m_cMessage);
}

/* A point drives a whole step in its first tick, and turns in its second. */
void CFeasibeeController::WalkAsPoint() {
   if(IsLastTick()) {
      Drive(m_fSpeed / m_fTick);
      return;
   }
   --m_nRunLeft;
   if(m_bBumped || m_nRunLeft <= 0) {
      DrawRun();
      Turn(m_pcRandom->Uniform(CRadians::SIGNED_RANGE));
   }
   else {
      Drive(0.0);
   }
   m_bBumped = false;
}

/* Diffusion: a body drives straight, turns away from obstacles, and takes a new heading after each run. */
void CFeasibeeController::WalkAsBody() {
   if(IsLastTick() && --m_nRunLeft <= 0) {
      DrawRun();
      m_cTurnLeft = m_pcRandom->Uniform(CRadians::SIGNED_RANGE);
   }
   CRadians cBearing;
   if(m_cTurnLeft == CRadians::ZERO && FindObstacle(cBearing)) {
      const CRadians cFastest(2.0 * m_fSpeed / WHEEL_DISTANCE * m_fTick);
      Turn(cBearing > CRadians::ZERO ? -cFastest : cFastest);
   }
   else if(m_cTurnLeft != CRadians::ZERO) {
      const CRadians cFastest(2.0 * m_fSpeed / WHEEL_DISTANCE * m_fTick);
      const CRadians cNow = Min(Max(m_cTurnLeft, -cFastest), cFastest);
      m_cTurnLeft -= cNow;
      Turn(cNow);
   }
   else {
      Drive(m_fSpeed);
   }
}

/* Return whether something is near and ahead, and at which bearing. */
bool CFeasibeeController::FindObstacle(CRadians& c_bearing) const {
   CVector2 cSum;
   for(const auto& sReading : m_pcProximity->GetReadings()) {
      cSum += CVector2(sReading.Value, sReading.Angle);
   }
   c_bearing = cSum.Angle();
   return cSum.Length() > OBSTACLE && Abs(c_bearing) < AHEAD;
}

/* Draw for how many steps the robot walks straight. */
void CFeasibeeController::DrawRun() {
   m_nRunLeft = Max<SInt32>(1, Ceil(m_pcRandom->Exponential(m_fMeanRun)));
}

void CFeasibeeController::Drive(Real f_metres_per_second) {
   m_pcWheels->SetLinearVelocity(100.0 * f_metres_per_second, 100.0 * f_metres_per_second);
}

/* Turn on the spot within one tick; positive angles are to the left. */
void CFeasibeeController::Turn(CRadians c_angle) {
   const Real fWheel = 100.0 * c_angle.GetValue() * WHEEL_DISTANCE / (2.0 * m_fTick);
   m_pcWheels->SetLinearVelocity(-fWheel, fWheel);
}

REGISTER_CONTROLLER(CFeasibeeController, "feasibee_controller")
