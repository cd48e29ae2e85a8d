// The slide of `typodont bench models` through CHAI3D's finger proxy: the same course, the same ball, meshes of the
// same fields; prints rows as `typodont bench --out` writes them. Built where CMake finds CHAI3D.
#include <chai3d.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/bench/model_tissues.h"
#include "haptics/tissue_mesh.h"

namespace {

using namespace typodont;
using haptics::bench::Course;
using haptics::bench::ModelTissue;

constexpr double kStiffness = 1.0;  // N/mm: CHAI3D's tolerances want numbers near one, so its world is in mm
constexpr std::size_t kSettled = 100;
constexpr int kPasses = 3;
constexpr double kLeast = 0.02;  // N

chai3d::cVector3d in_mm(const dvec3& p) {
  return {p.x / kMillimetre, p.y / kMillimetre, p.z / kMillimetre};
}

chai3d::cMesh* mesh_of(const haptics::TissueMesh& tissue) {
  auto* mesh = new chai3d::cMesh;  // the world deletes it
  for (const dvec3& v : tissue.vertices) mesh->newVertex(in_mm(v));
  for (const glm::uvec3& t : tissue.triangles) mesh->newTriangle(t.x, t.y, t.z);
  mesh->m_material->setStiffness(kStiffness);
  mesh->setUseCulling(false);
  mesh->createAABBCollisionDetector(haptics::bench::kProbeRadius / kMillimetre);
  return mesh;
}

void slide(const ModelTissue& tissue, const Course& course, double voxel_mm) {
  chai3d::cWorld world;
  world.addChild(mesh_of(haptics::surface_mesh(tissue.make(voxel_mm))));
  world.computeGlobalPositions(true);
  std::vector<double> times(course.hand.size(), 1e18);
  double squares = 0, sizes = 0, worst = 0;
  int count = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    chai3d::cAlgorithmFingerProxy proxy;
    proxy.initialize(&world, in_mm(course.hand.front()));
    proxy.setProxyRadius(haptics::bench::kProbeRadius / kMillimetre);
    for (std::size_t i = 0; i < course.hand.size(); ++i) {
      const Nanos start = thread_cpu_time();
      const chai3d::cVector3d f = proxy.computeForces(in_mm(course.hand[i]), chai3d::cVector3d(0, 0, 0));
      times[i] = std::min(times[i], static_cast<double>(thread_cpu_time() - start));
      const dvec3 force(f.x(), f.y(), f.z()), truth = kStiffness / kMillimetre * (course.truth[i] - course.hand[i]);
      if (pass > 0 || i < kSettled || glm::length(truth) < kLeast) continue;
      const double angle = glm::length(force) > 0
                               ? std::atan2(glm::length(glm::cross(force, truth)), glm::dot(force, truth)) / kDegree
                               : 180;
      const double size = 100 * (glm::length(force) / glm::length(truth) - 1);
      squares += angle * angle, sizes += size * size, worst = std::max(worst, angle), ++count;
    }
  }
  const auto row = [&](const char* measure, double error, const char* unit) {
    fmt::print("models,\"{}, slide, CHAI3D finger proxy: {}\",voxel {:g} mm,{:.6g},\"{}\",{:.6g},tick,,,,\n",
               tissue.name, measure, voxel_mm, error, unit, quantile(times, 0.5));
  };
  row("direction", std::sqrt(squares / std::max(count, 1)), "degree, rms");
  row("direction", worst, "degree, greatest");
  row("magnitude", std::sqrt(sizes / std::max(count, 1)), "%, rms");
  fmt::print("models,\"{}, slide, CHAI3D finger proxy: tick, 99.9 %\",voxel {:g} mm,,,{:.6g},tick,,,,\n", tissue.name,
             voxel_mm, quantile(times, 0.999));
}

}  // namespace

int main() {
  for (const ModelTissue& tissue : haptics::bench::analytic_tissues()) {
    const Course course = haptics::bench::slide_course(tissue, 4000);
    for (const double voxel_mm : {0.2, 0.1, 0.05}) slide(tissue, course, voxel_mm);
  }
}
