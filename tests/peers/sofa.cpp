// The sliding test of `typodont bench models` with SOFA (25.06). The ball is a particle that a spring with the stiffness
// of the tissue pulls to the hand. The triangles of our fields push it away through SOFA's contact constraints without
// friction (FreeMotionAnimationLoop, LocalMinDistance, FrictionContactConstraint). One step of the simulation is one
// tick. The force is the spring's. SOFA computes in millimetres, newtons and seconds. Prints rows in the format of
// `typodont bench --out`.
#include <fmt/format.h>
#include <sofa/component/animationloop/FreeMotionAnimationLoop.h>
#include <sofa/component/collision/detection/algorithm/BVHNarrowPhase.h>
#include <sofa/component/collision/detection/algorithm/BruteForceBroadPhase.h>
#include <sofa/component/collision/detection/algorithm/CollisionPipeline.h>
#include <sofa/component/collision/detection/intersection/LocalMinDistance.h>
#include <sofa/component/collision/geometry/LineModel.h>
#include <sofa/component/collision/geometry/PointModel.h>
#include <sofa/component/collision/geometry/SphereModel.h>
#include <sofa/component/collision/geometry/TriangleModel.h>
#include <sofa/component/collision/response/contact/CollisionResponse.h>
#include <sofa/component/constraint/lagrangian/correction/UncoupledConstraintCorrection.h>
#include <sofa/component/constraint/lagrangian/solver/GenericConstraintSolver.h>
#include <sofa/component/linearsolver/iterative/CGLinearSolver.h>
#include <sofa/component/mass/UniformMass.h>
#include <sofa/component/odesolver/backward/EulerImplicitSolver.h>
#include <sofa/component/solidmechanics/spring/RestShapeSpringsForceField.h>
#include <sofa/component/statecontainer/MechanicalObject.h>
#include <sofa/component/topology/container/constant/MeshTopology.h>
#include <sofa/simulation/Node.h>
#include <sofa/simulation/Simulation.h>
#include <sofa/simulation/graph/init.h>

#include "engine/base/units.h"
#include "haptics/tissue_mesh.h"
#include "peer.h"

namespace {

using namespace typodont;
using haptics::bench::kProbeRadius;
using haptics::bench::ModelTissue;
using peers::PeerTick;
using sofa::core::objectmodel::New;
using Vec3 = sofa::defaulttype::Vec3Types;
using State = sofa::component::statecontainer::MechanicalObject<Vec3>;
namespace component = sofa::component;

constexpr double kTick = 1e-3;                                     // s
constexpr double kSpring = peers::kStiffness * kMillimetre;        // N/mm
constexpr double kMass = 1e-8;     // t (10 mg): small, so that the ball lags little behind the hand
constexpr double kNear = 0.1;      // mm, distance from which on a triangle is a constraint
constexpr double kContact = 1e-4;  // mm, distance that the constraints keep

Vec3::Coord in_mm(const dvec3& p) {
  return {p.x / kMillimetre, p.y / kMillimetre, p.z / kMillimetre};
}

class ContactConstraints : public peers::Peer {
 public:
  ContactConstraints(const haptics::TissueMesh& surface, const dvec3& hand)
      : root_(sofa::simulation::getSimulation()->createNewGraph("root")) {
    root_->setGravity({0, 0, 0});
    root_->setDt(kTick);
    add_pipeline();
    add_tissue(surface);
    add_ball(hand);
    sofa::simulation::node::initRoot(root_.get());
  }
  ~ContactConstraints() override { sofa::simulation::node::unload(root_); }

  PeerTick tick(const dvec3& hand, bool) override {
    return peers::timed_tick([&] {
      sofa::helper::getWriteOnlyAccessor(*hand_->write(sofa::core::vec_id::write_access::position))[0] = in_mm(hand);
      sofa::simulation::node::animate(root_.get(), kTick);
      const Vec3::Coord& p = ball_->read(sofa::core::vec_id::read_access::position)->getValue()[0];
      const dvec3 ball = kMillimetre * dvec3(p[0], p[1], p[2]);
      return PeerTick{.force = peers::kStiffness * (ball - hand), .ball = ball};
    });
  }
  double volume() const override { return 0; }

 private:
  void add_pipeline() {
    namespace detection = component::collision::detection;
    root_->addObject(New<component::animationloop::FreeMotionAnimationLoop>());
    const auto solver = New<component::constraint::lagrangian::solver::GenericConstraintSolver>();
    solver->d_maxIt.setValue(1000);
    solver->d_tolerance.setValue(1e-9);
    root_->addObject(solver);
    root_->addObject(New<detection::algorithm::CollisionPipeline>());
    root_->addObject(New<detection::algorithm::BruteForceBroadPhase>());
    root_->addObject(New<detection::algorithm::BVHNarrowPhase>());
    const auto distance = New<detection::intersection::LocalMinDistance>();
    distance->setAlarmDistance(kNear);
    distance->setContactDistance(kContact);
    root_->addObject(distance);
    const auto response = New<component::collision::response::contact::CollisionResponse>();
    response->setDefaultResponseType("FrictionContactConstraint");
    response->d_responseParams.setValue("mu=0");
    root_->addObject(response);
  }

  void add_tissue(const haptics::TissueMesh& surface) {
    const auto node = root_->createChild("tissue");
    const auto topology = New<component::topology::container::constant::MeshTopology>();
    const auto state = New<State>();
    state->resize(surface.vertices.size());
    auto positions = sofa::helper::getWriteOnlyAccessor(*state->write(sofa::core::vec_id::write_access::position));
    for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
      positions[i] = in_mm(surface.vertices[i]);
      topology->addPoint(positions[i][0], positions[i][1], positions[i][2]);
    }
    for (const auto& t : surface.triangles) topology->addTriangle(t[0], t[1], t[2]);
    node->addObject(topology);
    node->addObject(state);
    const auto add = [&](const auto& model) {
      model->setSimulated(false);
      model->setMoving(false);
      node->addObject(model);
    };
    add(New<component::collision::geometry::TriangleCollisionModel<Vec3>>());
    add(New<component::collision::geometry::LineCollisionModel<Vec3>>());
    add(New<component::collision::geometry::PointCollisionModel<Vec3>>());
  }

  void add_ball(const dvec3& hand) {
    const auto at_hand = [&](const State::SPtr& state) {
      state->resize(1);
      sofa::helper::getWriteOnlyAccessor(*state->write(sofa::core::vec_id::write_access::position))[0] = in_mm(hand);
    };
    at_hand(hand_);
    root_->createChild("hand")->addObject(hand_);

    const auto node = root_->createChild("ball");
    node->addObject(New<component::odesolver::backward::EulerImplicitSolver>());
    const auto linear = New<component::linearsolver::iterative::CGLinearSolver<
        component::linearsolver::GraphScatteredMatrix, component::linearsolver::GraphScatteredVector>>();
    linear->d_maxIter.setValue(25);
    linear->d_tolerance.setValue(1e-12);
    linear->d_smallDenominatorThreshold.setValue(1e-30);
    node->addObject(linear);
    at_hand(ball_);
    node->addObject(ball_);
    const auto mass = New<component::mass::UniformMass<Vec3>>();
    mass->setTotalMass(kMass);
    node->addObject(mass);
    const auto spring = New<component::solidmechanics::spring::RestShapeSpringsForceField<Vec3>>();
    spring->d_stiffness.setValue({kSpring});
    spring->l_restMState.set(hand_.get());
    node->addObject(spring);
    const auto sphere = New<component::collision::geometry::SphereCollisionModel<Vec3>>();
    sphere->d_defaultRadius.setValue(kProbeRadius / kMillimetre);
    node->addObject(sphere);
    const auto correction = New<component::constraint::lagrangian::correction::UncoupledConstraintCorrection<Vec3>>();
    correction->d_defaultCompliance.setValue(1 / (kMass + kTick * kTick * kSpring));
    node->addObject(correction);
  }

  sofa::simulation::Node::SPtr root_;
  State::SPtr hand_ = New<State>(), ball_ = New<State>();
};

}  // namespace

int main() {
  sofa::simulation::graph::init();
  peers::print_header();
  for (const ModelTissue& tissue : haptics::bench::analytic_tissues()) {
    const haptics::bench::Course course = peers::slide_course(tissue);
    for (const double voxel_mm : {0.2, 0.1, 0.05}) {
      const haptics::TissueMesh surface = haptics::surface_mesh(tissue.make(voxel_mm));
      const peers::PeerModel sofa{
          "SOFA contact constraints", fmt::format("voxel {:g} mm", voxel_mm),
          [&](const dvec3& hand, bool) { return std::make_unique<ContactConstraints>(surface, hand); }};
      peers::print_slide(tissue, course, sofa);
    }
  }
}
