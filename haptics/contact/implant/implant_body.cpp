#include "haptics/contact/implant/implant_body.h"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/contact/implant/implant_model.h"
#include "haptics/cutting/placed_head.h"

namespace typodont::haptics::implant {

namespace {

bool is_bone(const TissueVolume& volume, const dvec3& p_W) {
  const glm::ivec3 at(glm::round(volume.frame().to_voxels(p_W)));
  float distance = 0;
  Tissue tissue = Tissue::kAir;
  volume.copy(at, glm::ivec3(1), &distance, &tissue);
  return distance < 0 && (tissue == Tissue::kCorticalBone || tissue == Tissue::kCancellousBone);
}

/// Throws Error unless there is bone around the wall of the bed (drilled hole) at half the bed's depth.
void check(const TissueVolume& volume, const Bed& bed, std::size_t index) {
  constexpr int kAround = 8;
  constexpr double kBehindWall = 0.5e-3;  // m; tissue is examined at this distance outside the bed's wall
  const dquat R = rotation_between({0, 0, -1}, bed.axis_W);
  const dvec3 middle = bed.entry_W + 0.5 * bed.depth * bed.axis_W;
  for (int i = 0; i < kAround; ++i) {
    const double a = 2 * kPi * i / kAround;
    const dvec3 p_W = middle + R * ((bed.radius + kBehindWall) * dvec3(std::cos(a), std::sin(a), 0));
    if (is_bone(volume, p_W)) continue;
    const dvec3 mm = p_W / kMillimetre;
    throw Error("model.implant", fmt::format("beds[{}]", index),
                fmt::format("no bone at ({:.2f}, {:.2f}, {:.2f}) mm, beside its wall", mm.x, mm.y, mm.z),
                "a bed inside bone");
  }
}

}  // namespace

ImplantBody::ImplantBody(TissueVolume tissue, std::span<const Tool> tools, const std::vector<Bed>& beds)
    : FieldBody(std::move(tissue), tools) {
  for (std::size_t i = 0; i < beds.size(); ++i) check(rasterize(), beds[i], i);
}

void ImplantBody::fill(const Cut& cut) {
  if (tool(cut).fill != Tissue::kAir) return FieldBody::fill(cut);
  TissueVolume& volume = rasterize();
  after_fill(volume.fill(PlacedHead(tool(cut), kPlacedTissue, cut.X_WB, volume.frame())));
  placed_ = true;
}

void ImplantBody::cut_out(Snapshot& snapshot, std::uint32_t held) {
  FieldBody::cut_out(snapshot, held);
  placed_ = false;
}

}  // namespace typodont::haptics::implant
