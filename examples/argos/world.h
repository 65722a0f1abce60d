/* Loop functions: they place robots and tasks, are the robots' eyes, and record what the swarm decides. */

#ifndef FEASIBEE_WORLD_H
#define FEASIBEE_WORLD_H

#include <fstream>
#include <vector>

#include <argos3/core/simulator/loop_functions.h>
#include <argos3/core/utility/math/rng.h>
#include <argos3/core/utility/math/vector2.h>
#include <argos3/plugins/robots/foot-bot/simulator/footbot_entity.h>

#include "controller.h"

class CFeasibeeWorld : public argos::CLoopFunctions {

public:

   void Init(argos::TConfigurationNode& t_node) override;
   void Reset() override;
   void PreStep() override;
   void PostStep() override;
   bool IsExperimentFinished() override;
   void PostExperiment() override;

private:

   struct SRobot {
      argos::CFootBotEntity* Entity;
      CFeasibeeController* Controller;
      argos::CVector2 Position;         /* at the end of the last step */
      std::vector<bool> InSight;        /* robots in sight at the end of the last step */
   };

   struct SWall {
      argos::CVector2 Low;
      argos::CVector2 High;
   };

   void ReadSettings(argos::TConfigurationNode& t_node);
   void FindWalls();
   bool IsClear(const argos::CVector2& c_position, argos::Real f_margin) const;
   bool Sees(const argos::CVector2& c_from, const argos::CVector2& c_to) const;
   void PlaceAll();
   argos::CVector2 DrawPosition(argos::Real f_margin);
   argos::CVector2 FreePosition(size_t un_placed);
   void Hold(SRobot& s_robot);
   void Look(size_t un_robot);
   void Transmit();
   void Count();
   argos::CVector2 PositionOf(const SRobot& s_robot) const;
   argos::Real SquareDistance(const argos::CVector2& c_from, const argos::CVector2& c_to) const;

   argos::CRandom::CRNG* m_pcRandom = nullptr;
   std::vector<SRobot> m_vecRobots;
   std::vector<argos::CVector2> m_vecTasks;
   std::vector<SWall> m_vecWalls;       /* of a place: boxes along the axes */

   argos::UInt32 m_unRobots = 0;
   argos::UInt32 m_unTasks = 0;
   argos::CVector2 m_cSize;             /* of the arena, which is centred at the origin; metres */
   bool m_bTorus = false;
   bool m_bBodies = false;
   argos::Real m_fRadius = 0.0;         /* of a robot */
   argos::Real m_fSight = 0.0;
   argos::Real m_fRadio = 0.0;
   argos::Real m_fMiss = 0.0;
   bool m_bCountSelf = false;
   argos::Real m_fThreshold = 0.9;
   argos::UInt32 m_unSteps = 0;
   bool m_bStopAtDecision = true;
   std::string m_strStepsFile;
   std::string m_strRunsFile;
   std::ofstream m_cStepsFile;

   argos::UInt32 m_unStep = 0;
   int m_nDecision = -1;
   argos::UInt32 m_unDecisionStep = 0;
   argos::Real m_fWay = 0.0;            /* of all robots, metres */
   size_t m_unMeetings = 0;             /* robots that came into a robot's sight */
   size_t m_unRobotsInSight = 0;        /* of all robots, summed over steps */
   size_t m_unTasksInSight = 0;
};

#endif
