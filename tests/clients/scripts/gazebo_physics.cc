// Loads an SDF world into Gazebo's physics (dartsim) and obeys commands from standard input, one a line:
//   ball NAME X Y Z RADIUS     a sphere of 0.1 kg
//   move NAME X Y Z            moves a model, as Gazebo's set_pose service does
//   push NAME VX VY STEPS      steps with the model's velocity set again before each one
//   wheels LEFT RIGHT STEPS    steps with the velocities, rad/s, of the joints left_joint and right_joint of `robot`
//   step STEPS
//   where NAME                 prints x, y, z of the model's first link
//   serve NAME                 acts as the Gazebo server for a player of the world of this name:
//   obeys its services, and
//                              prints time, model and new z for every model moved, until time
//                              continues
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <iostream>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>

#include <ignition/math/eigen3/Conversions.hh>
#include <ignition/msgs.hh>
#include <ignition/physics/ForwardStep.hh>
#include <ignition/physics/FrameSemantics.hh>
#include <ignition/physics/FreeGroup.hh>
#include <ignition/physics/GetEntities.hh>
#include <ignition/physics/Joint.hh>
#include <ignition/physics/RequestEngine.hh>
#include <ignition/physics/sdf/ConstructModel.hh>
#include <ignition/physics/sdf/ConstructWorld.hh>
#include <ignition/plugin/Loader.hh>
#include <ignition/transport/Node.hh>
#include <sdf/Model.hh>
#include <sdf/Physics.hh>
#include <sdf/Root.hh>
#include <sdf/World.hh>

namespace physics = ignition::physics;

using Features = physics::FeatureList<
    physics::ForwardStep, physics::GetModelFromWorld, physics::GetLinkFromModel, physics::GetJointFromModel,
    physics::LinkFrameSemantics, physics::FindFreeGroupFeature, physics::SetFreeGroupWorldPose,
    physics::SetFreeGroupWorldVelocity, physics::SetJointVelocityCommandFeature,
    physics::sdf::ConstructSdfWorld, physics::sdf::ConstructSdfModel>;

using World = physics::World3dPtr<Features>;

void move(World &world, const std::string &name, double x, double y, double z)
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << x, y, z;
  world->GetModel(name)->FindFreeGroup()->SetWorldPose(pose);
}

void serve(World &world, const std::string &name, const std::function<void()> &step, double lasts)
{
  using ignition::msgs::Boolean;
  std::mutex guard;
  long steps = 0;
  double until = 0;
  std::atomic<bool> done{false};
  std::function<bool(const ignition::msgs::WorldControl &, Boolean &)> control = [&](const auto &asked, auto &answer) {
    std::lock_guard<std::mutex> lock(guard);
    if (asked.has_run_to_sim_time()) until = asked.run_to_sim_time().sec() + asked.run_to_sim_time().nsec() * 1e-9;
    else if (!asked.pause()) done = true;
    answer.set_data(true);
    return true;
  };
  std::function<bool(const ignition::msgs::Pose_V &, Boolean &)> place = [&](const auto &asked, auto &answer) {
    std::lock_guard<std::mutex> lock(guard);
    for (const auto &pose : asked.pose())
    {
      move(world, pose.name(), pose.position().x(), pose.position().y(), pose.position().z());
      const auto at = world->GetModel(pose.name())->GetLink(0)->FrameDataRelativeToWorld().pose.translation();
      std::cout << steps * lasts << ' ' << pose.name() << ' ' << at.z() << std::endl;
    }
    answer.set_data(true);
    return true;
  };
  ignition::transport::Node node;
  node.Advertise("/world/" + name + "/control", control);
  node.Advertise("/world/" + name + "/set_pose_vector", place);
  auto stats = node.Advertise<ignition::msgs::WorldStatistics>("/world/" + name + "/stats");
  while (!done)
  {
    {
      std::lock_guard<std::mutex> lock(guard);
      for (; (steps + 0.5) * lasts < until; ++steps) step();
      ignition::msgs::WorldStatistics said;
      const long nanoseconds = std::lround(steps * lasts * 1e9);
      said.mutable_sim_time()->set_sec(nanoseconds / 1000000000);
      said.mutable_sim_time()->set_nsec(nanoseconds % 1000000000);
      said.set_paused(true);
      stats.Publish(said);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

int fail(const std::string &what)
{
  std::cerr << what << std::endl;
  return 1;
}

int main(int, char **arguments)
{
  ignition::plugin::Loader loader;
  const auto plugins = loader.LoadLib(arguments[1]);
  if (plugins.empty()) return fail("no engine in " + std::string(arguments[1]));
  const auto engine = physics::RequestEngine3d<Features>::From(loader.Instantiate(*plugins.begin()));
  if (!engine) return fail("the engine lacks a feature");
  sdf::Root root;
  const auto errors = root.Load(arguments[2]);
  if (!errors.empty()) return fail(errors.front().Message());
  auto world = engine->ConstructWorld(*root.WorldByIndex(0));
  physics::ForwardStep::Output output;
  physics::ForwardStep::State state;
  physics::ForwardStep::Input input;

  const double lasts = root.WorldByIndex(0)->PhysicsByIndex(0)->MaxStepSize();
  const auto once = [&] { world->Step(output, state, input); };
  std::string line, command, name;
  while (std::getline(std::cin, line))
  {
    std::istringstream words(line);
    words >> command;
    int steps = 0;
    double x = 0, y = 0, z = 0, radius = 0;
    if (command == "ball")
    {
      words >> name >> x >> y >> z >> radius;
      std::ostringstream text;
      text.precision(17);
      const double moment = 0.04 * radius * radius;
      text << "<sdf version='1.9'><model name='" << name << "'><pose>" << x << ' ' << y << ' ' << z
           << " 0 0 0</pose><link name='link'><inertial><mass>0.1</mass><inertia><ixx>" << moment << "</ixx><iyy>"
           << moment << "</iyy><izz>" << moment << "</izz></inertia></inertial><collision name='c'><geometry><sphere>"
           << "<radius>" << radius << "</radius></sphere></geometry></collision></link></model></sdf>";
      sdf::Root ball;
      if (!ball.LoadSdfString(text.str()).empty()) return fail("no ball");
      world->ConstructModel(*ball.Model());
      continue;
    }
    if (command == "wheels")
    {
      words >> x >> y >> steps;
      auto robot = world->GetModel("robot");
      for (; steps > 0; --steps)
      {
        robot->GetJoint("left_joint")->SetVelocityCommand(0, x);
        robot->GetJoint("right_joint")->SetVelocityCommand(0, y);
        once();
      }
      continue;
    }
    if (command == "serve")
    {
      words >> name;
      std::cout.precision(17);
      serve(world, name, once, lasts);
      continue;
    }
    if (command == "step")
    {
      for (words >> steps; steps > 0; --steps) once();
      continue;
    }
    words >> name;
    auto model = world->GetModel(name);
    if (!model) return fail("no model " + name);
    if (command == "move")
    {
      words >> x >> y >> z;
      if (!model->FindFreeGroup()) return fail("cannot move " + name);
      move(world, name, x, y, z);
    }
    else if (command == "push")
    {
      for (words >> x >> y >> steps; steps > 0; --steps)
      {
        model->FindFreeGroup()->SetWorldLinearVelocity({x, y, 0});
        once();
      }
    }
    else if (command == "where")
    {
      const Eigen::Vector3d at = model->GetLink(0)->FrameDataRelativeToWorld().pose.translation();
      std::cout.precision(17);
      std::cout << at.x() << ' ' << at.y() << ' ' << at.z() << std::endl;
    }
    else
      return fail("no command " + command);
  }
  return 0;
}
