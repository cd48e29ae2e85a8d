#include "haptics/contact/packing/packing_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "haptics/contact/packing/sphere_field.h"

namespace typodont::haptics::packing {

PackingBody::PackingBody(TissueVolume tissue, const SpherePacking& packing, std::span<const Tool> tools,
                         const Parameters& parameters)
    : volume_(std::move(tissue)),
      untouched_(volume_.clone()),
      packing_(packing),
      spheres_(packing, parameters.removal),
      original_(packing.center, packing.radius),
      buffers_(packing.size()) {
  if (const std::uint64_t hash = volume_.hash(); packing.tissue_hash != hash) {
    throw Error(parameters.file.string(), "tissue_hash", fmt::format("{:016x}", packing.tissue_hash),
                fmt::format("{:016x}, the tissue of this scene", hash));
  }
  for (const Tool& tool : tools) tools_.push_back(tool_spheres(tool, parameters.tool_spheres, parameters.seed));
}

void PackingBody::touch(int i) {
  unseen_.push_back(i);
  if (remembers_) written_.push_back(i);
}

void PackingBody::carve(const Cut& cut, bool) {
  packing::carve(spheres_, tools_[cut.tool], cut.X_WA, cut.X_WB, buffers_, [&](int i, const CutSphere& before) {
    if (in_stroke_) done_.back().changes.emplace_back(i, before);
    touch(i);
  });
}

void PackingBody::fill(const Cut&) {
  TYPODONT_CHECK(false);
}

void PackingBody::begin_stroke() {
  end_stroke();
  done_.emplace_back();
  undone_.clear();
  in_stroke_ = true;
}

void PackingBody::end_stroke() {
  if (in_stroke_ && done_.back().changes.empty()) done_.pop_back();
  in_stroke_ = false;
}

void PackingBody::set(int i, const CutSphere& sphere) {
  double& back = taken_back_[static_cast<std::size_t>(spheres_.tissue(i))];
  back -= spheres_.volume(i);
  spheres_.set(i, sphere);
  back += spheres_.volume(i);
  touch(i);
}

bool PackingBody::undo() {
  end_stroke();
  if (done_.empty()) return false;
  Stroke stroke = std::move(done_.back());
  done_.pop_back();
  for (auto change = stroke.changes.rbegin(); change != stroke.changes.rend(); ++change) {
    set(change->first, std::exchange(change->second, spheres_.sphere(change->first)));
  }
  undone_.push_back(std::move(stroke));
  return true;
}

bool PackingBody::redo() {
  end_stroke();
  if (undone_.empty()) return false;
  Stroke stroke = std::move(undone_.back());
  undone_.pop_back();
  for (auto& [i, sphere] : stroke.changes) set(i, std::exchange(sphere, spheres_.sphere(i)));
  done_.push_back(std::move(stroke));
  return true;
}

std::unique_ptr<Snapshot> PackingBody::make_snapshot() const {
  auto snapshot = std::make_unique<PackingSnapshot>();
  snapshot->spheres = spheres_;
  return snapshot;
}

double PackingBody::travel() const {
  return std::numeric_limits<double>::infinity();
}

void PackingBody::cut_out(Snapshot& snapshot) {
  static_cast<PackingSnapshot&>(snapshot).spheres = spheres_;
}

void PackingBody::remember_writes(bool wanted) {
  remembers_ = wanted;
  written_.clear();
}

void PackingBody::bring_up_to_date(Snapshot& snapshot) {
  SphereTissue& copy = static_cast<PackingSnapshot&>(snapshot).spheres;
  for (const int i : written_) copy.set(i, spheres_.sphere(i));
  written_.clear();
}

TissueVolume& PackingBody::rasterize() {
  if (unseen_.empty()) return volume_;
  // Blocks of 8³ voxels around all that changed, each made anew once.
  constexpr int kBlock = 8;
  const auto less = [](const glm::ivec3& a, const glm::ivec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::set<glm::ivec3, decltype(less)> blocks(less);
  const VoxelFrame& frame = volume_.frame();
  for (const int i : unseen_) {
    const auto k = static_cast<std::size_t>(i);
    const double reach = packing_.radius[k] + SphereField::kMargin * frame.voxel;
    const auto block = [&](double side) {
      return glm::ivec3(glm::floor(frame.to_voxels(packing_.center[k] + side * reach) / static_cast<double>(kBlock)));
    };
    const glm::ivec3 lo = block(-1), hi = block(1);
    for (int x = lo.x; x <= hi.x; ++x)
      for (int y = lo.y; y <= hi.y; ++y)
        for (int z = lo.z; z <= hi.z; ++z) blocks.insert({x, y, z});
  }
  unseen_.clear();
  SphereField field(packing_, spheres_, original_, untouched_);
  for (const glm::ivec3& block : blocks) volume_.replace(field.samples(kBlock * block, glm::ivec3(kBlock)));
  return volume_;
}

}  // namespace typodont::haptics::packing
