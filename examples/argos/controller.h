/* A foot-bot that walks at random, and decides with its swarm whether the tasks are feasible. */

#ifndef FEASIBEE_CONTROLLER_H
#define FEASIBEE_CONTROLLER_H

#include <argos3/core/control_interface/ci_controller.h>
#include <argos3/core/utility/datatypes/byte_array.h>
#include <argos3/core/utility/math/rng.h>
#include <argos3/plugins/robots/foot-bot/control_interface/ci_footbot_proximity_sensor.h>
#include <argos3/plugins/robots/generic/control_interface/ci_differential_steering_actuator.h>
#include <argos3/plugins/robots/generic/control_interface/ci_range_and_bearing_actuator.h>
#include <argos3/plugins/robots/generic/control_interface/ci_range_and_bearing_sensor.h>

#include "mind.h"

class CFeasibeeController : public argos::CCI_Controller {

public:

   ~CFeasibeeController() override;

   void Init(argos::TConfigurationNode& t_node) override;
   void ControlStep() override;
   void Reset() override;

   /* What a camera and a bumper would report. The loop functions stand in for both. */
   void See(int n_robots, int n_tasks);
   void Bump();

   /* A message that arrived otherwise than by range-and-bearing: on the torus, which ARGoS lacks. */
   void Receive(const argos::CByteArray& c_message);

   /* The message of the present step. */
   const argos::CByteArray& GetMessage() const { return m_cMessage; }

   int GetOpinion() const { return mind_opinion(m_ptMind); }
   bool HasDeclared() const { return mind_declared(m_ptMind); }

   /* Whether the next call of ControlStep() is the last of a step; whether the last call was. */
   bool IsLastTick() const { return m_unTick + 1 == m_unTicksPerStep; }
   bool HasEndedStep() const { return m_unTick == 0; }

private:

   void ReadDecision(argos::TConfigurationNode& t_node);
   void Decide();
   void WalkAsPoint();
   void WalkAsBody();
   bool FindObstacle(argos::CRadians& c_bearing) const;
   void DrawRun();
   void Drive(argos::Real f_metres_per_second);
   void Turn(argos::CRadians c_angle);

   argos::CCI_DifferentialSteeringActuator* m_pcWheels = nullptr;
   argos::CCI_RangeAndBearingActuator* m_pcRadioOut = nullptr;
   argos::CCI_RangeAndBearingSensor* m_pcRadioIn = nullptr;
   argos::CCI_FootBotProximitySensor* m_pcProximity = nullptr; /* none: the robot is a point */
   argos::CRandom::CRNG* m_pcRandom = nullptr;

   mind_settings m_tSettings = {};
   std::string m_strStrategy;
   mind* m_ptMind = nullptr;
   argos::CByteArray m_cMessage;
   std::vector<argos::CByteArray> m_vecReceived;
   int m_nRobotsSeen = 0;
   int m_nTasksSeen = 0;

   argos::UInt32 m_unTicksPerStep = 1;
   argos::UInt32 m_unTick = 0;      /* of the present step */
   argos::Real m_fTick = 1.0;       /* seconds */
   argos::Real m_fSpeed = 0.0;      /* metres per step, which is a second */
   argos::Real m_fMeanRun = 1.0;    /* steps */
   argos::SInt32 m_nRunLeft = 0;    /* steps */
   argos::CRadians m_cTurnLeft;     /* by which a body has to turn before it drives on */
   bool m_bBumped = false;
   argos::Real m_fLoss = 0.0;
   argos::UInt16 m_unId = 0;
};

#endif
