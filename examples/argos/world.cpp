#include "world.h"

#include <algorithm>
#include <cmath>

#include <argos3/core/utility/configuration/argos_configuration.h>
#include <argos3/plugins/simulator/entities/box_entity.h>

using namespace argos;

namespace {

const Real FOOTBOT_RADIUS = 0.085036758; /* metres */

/* Return the difference of two coordinates, the short way round. */
Real Around(Real f_difference, Real f_side) {
   return f_difference - f_side * std::round(f_difference / f_side);
}

/* Keep the part of a way, from 0 to 1, in which a coordinate is between two others. */
void Clip(Real f_from, Real f_to, Real f_low, Real f_high, Real& f_first, Real& f_last) {
   const Real fWay = f_to - f_from;
   if(fWay == 0.0) {
      f_last = f_from < f_low || f_from > f_high ? -1.0 : f_last;
      return;
   }
   f_first = std::max(f_first, std::min((f_low - f_from) / fWay, (f_high - f_from) / fWay));
   f_last = std::min(f_last, std::max((f_low - f_from) / fWay, (f_high - f_from) / fWay));
}

}

void CFeasibeeWorld::Init(TConfigurationNode& t_node) {
   m_pcRandom = CRandom::CreateRNG("argos");
   ReadSettings(t_node);
   FindWalls();
   PlaceAll();
   Reset();
}

void CFeasibeeWorld::ReadSettings(TConfigurationNode& t_node) {
   TConfigurationNode& tWorld = GetNode(t_node, "world");
   std::string strBoundary;
   GetNodeAttribute(tWorld, "size", m_cSize);
   GetNodeAttribute(tWorld, "boundary", strBoundary);
   GetNodeAttribute(tWorld, "bodies", m_bBodies);
   GetNodeAttribute(tWorld, "robots", m_unRobots);
   GetNodeAttribute(tWorld, "tasks", m_unTasks);
   m_bTorus = strBoundary == "torus";
   TConfigurationNode& tSensing = GetNode(t_node, "sensing");
   GetNodeAttribute(tSensing, "range", m_fSight);
   GetNodeAttribute(tSensing, "miss", m_fMiss);
   GetNodeAttribute(tSensing, "count_self", m_bCountSelf);
   GetNodeAttribute(GetNode(t_node, "radio"), "range", m_fRadio);
   TConfigurationNode& tRun = GetNode(t_node, "run");
   GetNodeAttribute(tRun, "threshold", m_fThreshold);
   GetNodeAttribute(tRun, "steps", m_unSteps);
   GetNodeAttribute(tRun, "stop_at_decision", m_bStopAtDecision);
   GetNodeAttributeOrDefault(tRun, "steps_file", m_strStepsFile, m_strStepsFile);
   GetNodeAttributeOrDefault(tRun, "runs_file", m_strRunsFile, m_strRunsFile);
}

/* Find the boxes that are walls of a place; those around the arena are others. */
void CFeasibeeWorld::FindWalls() {
   if(!m_bBodies) {
      return; /* without any box, ARGoS doesn't know the type */
   }
   for(auto& tBox : GetSpace().GetEntitiesByType("box")) {
      auto* pcBox = any_cast<CBoxEntity*>(tBox.second);
      if(pcBox->GetId().rfind("place_", 0) == 0) {
         const CVector3& cMiddle = pcBox->GetEmbodiedEntity().GetOriginAnchor().Position;
         const CVector3 cHalf = 0.5 * pcBox->GetSize();
         m_vecWalls.push_back({CVector2(cMiddle.GetX() - cHalf.GetX(), cMiddle.GetY() - cHalf.GetY()),
                               CVector2(cMiddle.GetX() + cHalf.GetX(), cMiddle.GetY() + cHalf.GetY())});
      }
   }
}

/* Return whether a position is a margin away from all walls of the place. */
bool CFeasibeeWorld::IsClear(const CVector2& c_position, Real f_margin) const {
   for(const SWall& sWall : m_vecWalls) {
      const Real fX = std::max({sWall.Low.GetX() - c_position.GetX(), 0.0, c_position.GetX() - sWall.High.GetX()});
      const Real fY = std::max({sWall.Low.GetY() - c_position.GetY(), 0.0, c_position.GetY() - sWall.High.GetY()});
      if(Square(fX) + Square(fY) <= Square(f_margin)) {
         return false;
      }
   }
   return true;
}

/* Return whether a position is in sight: within range, and no wall of the place between. */
bool CFeasibeeWorld::Sees(const CVector2& c_from, const CVector2& c_to) const {
   if(SquareDistance(c_from, c_to) > Square(m_fSight)) {
      return false;
   }
   for(const SWall& sWall : m_vecWalls) {
      Real fFirst = 0.0;
      Real fLast = 1.0;
      Clip(c_from.GetX(), c_to.GetX(), sWall.Low.GetX(), sWall.High.GetX(), fFirst, fLast);
      Clip(c_from.GetY(), c_to.GetY(), sWall.Low.GetY(), sWall.High.GetY(), fFirst, fLast);
      if(fFirst <= fLast) {
         return false;
      }
   }
   return true;
}

/* Place robots and tasks uniformly at random; bodies so that none overlaps another, and all off walls. */
void CFeasibeeWorld::PlaceAll() {
   for(UInt32 i = 0; i < m_unRobots; ++i) {
      const CVector2 cPosition = FreePosition(i);
      const CRadians cHeading = m_pcRandom->Uniform(CRadians::SIGNED_RANGE);
      auto* pcEntity = new CFootBotEntity(
         "robot" + ToString(i), "feasibee",
         CVector3(cPosition.GetX(), cPosition.GetY(), 0.0), CQuaternion(cHeading, CVector3::Z),
         m_fRadio, MIND_MESSAGE_BYTES);
      AddEntity(*pcEntity);
      auto& cController =
         dynamic_cast<CFeasibeeController&>(pcEntity->GetControllableEntity().GetController());
      m_vecRobots.push_back({pcEntity, &cController, cPosition, std::vector<bool>(m_unRobots)});
   }
   for(UInt32 i = 0; i < m_unTasks; ++i) {
      m_vecTasks.push_back(DrawPosition(m_vecWalls.empty() ? 0.0 : FOOTBOT_RADIUS));
   }
   for(size_t i = 0; i < m_vecRobots.size(); ++i) {
      Look(i);
   }
   m_unMeetings = m_unRobotsInSight = m_unTasksInSight = 0;
}

CVector2 CFeasibeeWorld::DrawPosition(Real f_margin) {
   const Real fX = 0.5 * m_cSize.GetX() - f_margin;
   const Real fY = 0.5 * m_cSize.GetY() - f_margin;
   CVector2 cPosition;
   do {
      cPosition.SetX(m_pcRandom->Uniform(CRange<Real>(-fX, fX))); /* two statements: the order is ours */
      cPosition.SetY(m_pcRandom->Uniform(CRange<Real>(-fY, fY)));
   } while(!IsClear(cPosition, f_margin));
   return cPosition;
}

CVector2 CFeasibeeWorld::FreePosition(size_t un_placed) {
   for(int nTry = 0; nTry < 10000; ++nTry) {
      const CVector2 cPosition = DrawPosition(m_bTorus ? 0.0 : FOOTBOT_RADIUS);
      bool bFree = true;
      for(size_t i = 0; m_bBodies && i < un_placed; ++i) {
         bFree = bFree && SquareDistance(cPosition, m_vecRobots[i].Position) >= 4 * Square(FOOTBOT_RADIUS);
      }
      if(bFree) {
         return cPosition;
      }
   }
   THROW_ARGOSEXCEPTION("robots=\"" << m_unRobots << "\": no room for robot " << un_placed);
}

void CFeasibeeWorld::Reset() {
   if(m_unStep > 0) {
      THROW_ARGOSEXCEPTION("This world runs once: start argos3 again, with another random_seed");
   }
   if(!m_strStepsFile.empty()) {
      m_cStepsFile.open(m_strStepsFile, std::ios::trunc);
      m_cStepsFile << "step,feasible,infeasible,declared\n";
   }
   Count();
}

/* After robots have moved, before they sense. */
void CFeasibeeWorld::PreStep() {
   if(!m_bBodies) {
      for(SRobot& sRobot : m_vecRobots) {
         Hold(sRobot);
      }
   }
   if(m_vecRobots.front().Controller->IsLastTick()) {
      for(size_t i = 0; i < m_vecRobots.size(); ++i) {
         Look(i);
      }
      for(SRobot& sRobot : m_vecRobots) {
         const CVector2 cNow = PositionOf(sRobot);
         m_fWay += std::sqrt(SquareDistance(cNow, sRobot.Position));
         sRobot.Position = cNow;
      }
      if(m_bTorus) {
         Transmit();
      }
   }
}

/* Keep a point in the arena: round the torus, or back to where it was before the wall. */
void CFeasibeeWorld::Hold(SRobot& s_robot) {
   const CVector2 cNow = PositionOf(s_robot);
   CVector2 cHeld = cNow;
   if(m_bTorus) {
      cHeld.Set(Around(cNow.GetX(), m_cSize.GetX()), Around(cNow.GetY(), m_cSize.GetY()));
   }
   else if(std::abs(cNow.GetX()) > 0.5 * m_cSize.GetX() - FOOTBOT_RADIUS ||
           std::abs(cNow.GetY()) > 0.5 * m_cSize.GetY() - FOOTBOT_RADIUS) {
      cHeld = s_robot.Position;
      s_robot.Controller->Bump();
   }
   if(cHeld != cNow) {
      CEmbodiedEntity& cBody = s_robot.Entity->GetEmbodiedEntity();
      MoveEntity(cBody, CVector3(cHeld.GetX(), cHeld.GetY(), 0.0), cBody.GetOriginAnchor().Orientation,
                 false, true);
   }
}

/* Report to a robot how many robots and tasks are in its sight. */
void CFeasibeeWorld::Look(size_t un_robot) {
   SRobot& sRobot = m_vecRobots[un_robot];
   const CVector2 cFrom = PositionOf(sRobot);
   int nRobots = m_bCountSelf;
   int nTasks = 0;
   for(size_t i = 0; i < m_vecRobots.size(); ++i) {
      const bool bInSight = i != un_robot && Sees(cFrom, PositionOf(m_vecRobots[i]));
      m_unMeetings += bInSight && !sRobot.InSight[i];
      sRobot.InSight[i] = bInSight;
      m_unRobotsInSight += bInSight;
      nRobots += bInSight && !(m_fMiss > 0.0 && m_pcRandom->Bernoulli(m_fMiss));
   }
   for(const CVector2& cTask : m_vecTasks) {
      const bool bInSight = Sees(cFrom, cTask);
      m_unTasksInSight += bInSight;
      nTasks += bInSight && !(m_fMiss > 0.0 && m_pcRandom->Bernoulli(m_fMiss));
   }
   sRobot.Controller->See(nRobots, nTasks);
}

/* The radio of the torus: range-and-bearing doesn't reach round it. */
void CFeasibeeWorld::Transmit() {
   for(SRobot& sTo : m_vecRobots) {
      for(SRobot& sFrom : m_vecRobots) {
         if(&sTo != &sFrom && SquareDistance(sTo.Position, sFrom.Position) <= Square(m_fRadio)) {
            sTo.Controller->Receive(sFrom.Controller->GetMessage());
         }
      }
   }
}

/* After robots have decided. */
void CFeasibeeWorld::PostStep() {
   if(m_vecRobots.front().Controller->HasEndedStep()) {
      ++m_unStep;
      Count();
   }
}

/* Count opinions, write them, and look whether the swarm has decided. */
void CFeasibeeWorld::Count() {
   int pnHolding[2] = {0, 0};
   int nDeclared = 0;
   for(const SRobot& sRobot : m_vecRobots) {
      const int nOpinion = sRobot.Controller->GetOpinion();
      if(nOpinion >= 0) {
         ++pnHolding[nOpinion];
      }
      nDeclared += sRobot.Controller->HasDeclared();
   }
   if(m_cStepsFile.is_open()) {
      m_cStepsFile << m_unStep << ',' << pnHolding[1] << ',' << pnHolding[0] << ',' << nDeclared << '\n';
   }
   for(int nOpinion = 0; m_nDecision < 0 && nOpinion < 2; ++nOpinion) {
      if(pnHolding[nOpinion] > m_fThreshold * m_unRobots + 1e-9) { /* 0.9 isn't exact */
         m_nDecision = nOpinion;
         m_unDecisionStep = m_unStep;
      }
   }
}

bool CFeasibeeWorld::IsExperimentFinished() {
   return m_unStep >= m_unSteps || (m_bStopAtDecision && m_nDecision >= 0);
}

/* Append a line to the file of runs: seed, decision, its step, and how robots moved, met and saw. */
void CFeasibeeWorld::PostExperiment() {
   if(m_strRunsFile.empty()) {
      return;
   }
   const char* pchDecision = m_nDecision < 0 ? "undecided" : m_nDecision == 1 ? "feasible" : "infeasible";
   const Real fRobotSteps = static_cast<Real>(m_unRobots) * std::max<UInt32>(m_unStep, 1);
   std::ofstream cFile(m_strRunsFile, std::ios::app);
   cFile << GetSimulator().GetRandomSeed() << ',' << pchDecision << ',' << m_unDecisionStep << ','
         << m_unStep << ',' << m_fWay / fRobotSteps << ',' << m_unMeetings / fRobotSteps << ','
         << m_unRobotsInSight / fRobotSteps << ',' << m_unTasksInSight / fRobotSteps << '\n';
}

CVector2 CFeasibeeWorld::PositionOf(const SRobot& s_robot) const {
   const CVector3& cPosition = s_robot.Entity->GetEmbodiedEntity().GetOriginAnchor().Position;
   return CVector2(cPosition.GetX(), cPosition.GetY());
}

Real CFeasibeeWorld::SquareDistance(const CVector2& c_from, const CVector2& c_to) const {
   CVector2 cWay = c_to - c_from;
   if(m_bTorus) {
      cWay.Set(Around(cWay.GetX(), m_cSize.GetX()), Around(cWay.GetY(), m_cSize.GetY()));
   }
   return cWay.SquareLength();
}

REGISTER_LOOP_FUNCTIONS(CFeasibeeWorld, "feasibee_world")
