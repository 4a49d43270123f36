// A controller for Stage: prints what a robot's ranger sees where it stands, drives straight ahead, and prints where it ends.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include "stage.hh"
using namespace Stg;

static ModelRanger *ranger;
static int updates = 0;

static int Step(Model *mod, void *)
{
  ModelPosition *robot = (ModelPosition *)mod;
  updates++;
  if (updates == 3) {
    Pose p = robot->GetGlobalPose();
    printf("\nPOSE %.12g %.12g %.12g\nRANGES", p.x, p.y, p.a);
    for (double range : ranger->GetSensors()[0].ranges)
      printf(" %.9g", range);
    printf("\n");
    robot->SetXSpeed(0.1);
  }
  if (updates > 3 && (robot->Stalled() || updates > 400)) {
    Pose p = robot->GetGlobalPose();
    printf("END %d %.9g %.9g\n", (int)robot->Stalled(), p.x, p.y);
    fflush(stdout);
    _Exit(0);
  }
  return 0;
}

extern "C" int Init(Model *mod, CtrlArgs *)
{
  ranger = (ModelRanger *)mod->GetChild("ranger:0");
  ranger->Subscribe();
  ((ModelPosition *)mod)->Subscribe();
  mod->AddCallback(Model::CB_UPDATE, Step, NULL);
  return 0;
}
