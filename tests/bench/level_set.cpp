#include "tests/bench/level_set.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "engine/base/measure.h"
#include "engine/base/voxels.h"

namespace typodont::bench {

using openvdb::FloatGrid;

struct LevelSet::Impl {
  VoxelFrame frame;
  float band;
  FloatGrid::Ptr grid;  // distances and coordinates in voxels
  std::unique_ptr<FloatGrid::ConstAccessor> at;
};

static FloatGrid::Ptr sphere(double radius, const dvec3& c, float band) {
  openvdb::initialize();
  return openvdb::tools::createLevelSetSphere<FloatGrid>(
      static_cast<float>(radius), openvdb::Vec3f(openvdb::Vec3d(c.x, c.y, c.z)), 1.0f, band, /*threaded=*/false);
}

LevelSet::LevelSet(const haptics::DenseTissue& tissue, float band) {
  openvdb::initialize();
  impl_.reset(new Impl{tissue.frame, band, FloatGrid::create(band), {}});
  impl_->grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto set = impl_->grid->getAccessor();
  const auto to_voxels = static_cast<float>(1 / tissue.frame.voxel);
  for_each_voxel(tissue.size, [&](int x, int y, int z) {
    const float d = tissue.distance[tissue.at(x, y, z)] * to_voxels;
    if (std::abs(d) < band) set.setValue({x, y, z}, d);
  });
  openvdb::tools::signedFloodFill(impl_->grid->tree());
  impl_->at = std::make_unique<FloatGrid::ConstAccessor>(impl_->grid->getConstAccessor());
}

LevelSet::LevelSet(double radius, const dvec3& center, float band)
    : impl_(new Impl{{}, band, sphere(radius, center, band), {}}) {}

LevelSet::~LevelSet() = default;

void LevelSet::cut_ball(const dvec3& center_W, double radius) {
  const auto ball = sphere(radius / impl_->frame.voxel, impl_->frame.to_voxels(center_W), impl_->band);
  openvdb::tools::csgDifference(*impl_->grid, *ball);
}

double LevelSet::volume() const {
  double voxels = 0;
  for (auto it = impl_->grid->cbeginValueAll(); it; ++it) {
    const double fraction = std::clamp(0.5 - static_cast<double>(*it), 0.0, 1.0);
    if (fraction > 0) voxels += fraction * static_cast<double>(it.getVoxelCount());
  }
  return voxels * std::pow(impl_->frame.voxel, 3);
}

dvec3 LevelSet::push(const dvec3& center_W, double radius) const {
  const dvec3 c = impl_->frame.to_voxels(center_W);
  const auto distance = [&](const dvec3& p) {
    return static_cast<double>(openvdb::tools::QuadraticSampler::sample(*impl_->at, openvdb::Vec3R(p.x, p.y, p.z)));
  };
  constexpr double kStep = 0.5;  // voxels, of the central differences
  dvec3 gradient;
  for (int k = 0; k < 3; ++k) {
    dvec3 step(0);
    step[k] = kStep;
    gradient[k] = distance(c + step) - distance(c - step);
  }
  const double depth = radius - distance(c) * impl_->frame.voxel, slope = glm::length(gradient);
  return depth > 0 && slope > 0 ? center_W + depth / slope * gradient : center_W;
}

double LevelSet::extract(int repeats, Mesh& mesh) const {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  const double ns =
      measure(repeats, [&] { openvdb::tools::volumeToMesh(*impl_->grid, points, triangles, quads, 0.0, 0.0); }).median;
  mesh = {};
  for (const auto& p : points) mesh.points.push_back({p.x(), p.y(), p.z()});
  for (const auto& t : triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
  for (const auto& q : quads) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return ns;
}

}  // namespace typodont::bench
