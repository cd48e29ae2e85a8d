// The sliding test of `typodont bench models`, computed with CHAI3D's finger proxy (cAlgorithmFingerProxy, 3.3.0) and
// with our default model. Both use the same path, the same ball of 1.2 mm and the same clock. CHAI3D gets the triangles
// of our fields; the radius of its proxy is the radius of the ball. Prints rows in the format of `typodont bench
// --out`.
#include <chai3d.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/bench/model_tissues.h"
#include "haptics/bench/scene.h"
#include "haptics/tissue_mesh.h"

namespace {

using namespace typodont;
using haptics::bench::Course;
using haptics::bench::ModelTissue;

constexpr double kStiffness = 1000;    // N/m
constexpr std::size_t kSettled = 100;  // ticks until the hand is on the surface
constexpr int kPasses = 3;             // the shortest time of each tick counts
constexpr double kLeast = 0.02;        // N, a smaller force has no reliable direction

/// Starts from the beginning and returns the force (N) for each position of the hand (m). The time of a call is the
/// time of the tick.
using Force = std::function<dvec3(const dvec3& hand)>;

void slide(const std::string& tissue, const std::string& model, double voxel_mm, const Course& course,
           const std::function<Force()>& begin) {
  std::vector<double> times(course.hand.size(), 1e18);
  double squares = 0, sizes = 0, worst = 0;
  int count = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Force force_at = begin();
    for (std::size_t i = 0; i < course.hand.size(); ++i) {
      const Nanos start = thread_cpu_time();
      const dvec3 force = force_at(course.hand[i]);
      times[i] = std::min(times[i], static_cast<double>(thread_cpu_time() - start));
      const dvec3 truth = kStiffness * (course.truth[i] - course.hand[i]);
      if (pass > 0 || i < kSettled || glm::length(truth) < kLeast) continue;
      const double angle = glm::length(force) > 0 ? haptics::bench::degrees_between(force, truth) : 180;
      const double size = 100 * (glm::length(force) / glm::length(truth) - 1);
      squares += angle * angle, sizes += size * size, worst = std::max(worst, angle), ++count;
    }
  }
  const auto row = [&](const char* measure, double error, const char* unit) {
    fmt::print("models,\"{}, slide, {}: {}\",voxel {:g} mm,{:.6g},\"{}\",{:.6g},tick,,,,\n", tissue, model, measure,
               voxel_mm, error, unit, quantile(times, 0.5));
  };
  row("direction", std::sqrt(squares / std::max(count, 1)), "degree, rms");
  row("direction", worst, "degree, greatest");
  row("magnitude", std::sqrt(sizes / std::max(count, 1)), "%, rms");
  fmt::print("models,\"{}, slide, {}: tick, 99.9 %\",voxel {:g} mm,,,{:.6g},tick,,,,\n", tissue, model, voxel_mm,
             quantile(times, 0.999));
}

/// CHAI3D's tolerances assume numbers near one, so its world is in millimetres.
chai3d::cVector3d in_mm(const dvec3& p) {
  return {p.x / kMillimetre, p.y / kMillimetre, p.z / kMillimetre};
}

Force chai3d_proxy(chai3d::cWorld& world, const dvec3& from) {
  const auto proxy = std::make_shared<chai3d::cAlgorithmFingerProxy>();
  proxy->initialize(&world, in_mm(from));
  proxy->setProxyRadius(haptics::bench::kProbeRadius / kMillimetre);
  return [proxy](const dvec3& hand) {
    const chai3d::cVector3d f = proxy->computeForces(in_mm(hand), chai3d::cVector3d(0, 0, 0));
    return dvec3(f.x(), f.y(), f.z());
  };
}

void slide_through_chai3d(const ModelTissue& tissue, const Course& course, double voxel_mm) {
  const haptics::TissueMesh surface = haptics::surface_mesh(tissue.make(voxel_mm));
  chai3d::cWorld world;
  auto* mesh = new chai3d::cMesh;  // the world deletes it
  for (const dvec3& v : surface.vertices) mesh->newVertex(in_mm(v));
  for (const auto& t : surface.triangles) mesh->newTriangle(t[0], t[1], t[2]);
  mesh->m_material->setStiffness(kStiffness * kMillimetre);
  mesh->setUseCulling(false);
  mesh->createAABBCollisionDetector(haptics::bench::kProbeRadius / kMillimetre);
  world.addChild(mesh);
  world.computeGlobalPositions(true);
  slide(tissue.name, "CHAI3D finger proxy", voxel_mm, course, [&] { return chai3d_proxy(world, course.hand.front()); });
}

void slide_through_default(const ModelTissue& tissue, const Course& course, double voxel_mm) {
  slide(tissue.name, "offset", voxel_mm, course, [&]() -> Force {
    haptics::ServoSettings settings;
    const double diameter = 2 * haptics::bench::kProbeRadius;
    settings.tool = haptics::bench::head(haptics::HeadShape::kSphere, diameter, diameter);
    settings.stiffness = kStiffness;
    settings.damping = 0, settings.friction = settings.cutting = false;
    const auto scene = std::make_shared<haptics::bench::Scene>(tissue.make(voxel_mm), settings);
    return [scene](const dvec3& hand) {
      scene->tick({hand}, 0);
      return scene->last.f_model_W;
    };
  });
}

}  // namespace

int main() {
  fmt::print("part,case,knob,error,error_unit,time_ns,per,baseline,ratio,size,size_unit\n");
  for (const ModelTissue& tissue : haptics::bench::analytic_tissues()) {
    const Course course = haptics::bench::slide_course(tissue, 2500);
    for (const double voxel_mm : {0.2, 0.1, 0.05}) {
      slide_through_chai3d(tissue, course, voxel_mm);
      slide_through_default(tissue, course, voxel_mm);
    }
  }
}
