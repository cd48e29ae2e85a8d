#include "haptics/volume/emptied_piece.h"

#include <algorithm>

#include "engine/base/voxels.h"
#include "haptics/sweep.h"

namespace typodont::haptics {
namespace {

/// For each sample: distance to the piece (if `piece`) or to the remaining tissue, voxels; very large for far samples.
/// Passes the nearest sample just below the surface from neighbour to neighbour (Danielsson 1980).
std::vector<float> distances_to(bool piece, const PieceBox& box) {
  // voxels; the search starts from the samples at most this far below the surface
  constexpr float kShell = 2;
  const auto place = [&](std::int32_t i) {
    const int xy = i / box.size.z;
    return glm::ivec3(xy / box.size.y, xy % box.size.y, i % box.size.z);
  };
  std::vector<float> d(box.distance.size(), 1e9f);
  std::vector<std::int32_t> from(d.size(), -1), queue;
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (!(box.distance[i] < 0 && box.distance[i] > -kShell) || (box.loose[i] != 0) != piece) continue;
    d[i] = box.distance[i], from[i] = static_cast<std::int32_t>(i);
    queue.push_back(from[i]);
  }
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const std::int32_t f = from[static_cast<std::size_t>(queue[head])];
    const glm::ivec3 p = place(queue[head]), source = place(f);
    for (int step = 0; step < 27; ++step) {
      const glm::ivec3 q = p + glm::ivec3(step / 9 - 1, step / 3 % 3 - 1, step % 3 - 1);
      if (!in_grid(q, box.size)) continue;
      const float there = glm::length(glm::vec3(q - source)) + box.distance[static_cast<std::size_t>(f)];
      const std::size_t i = voxel_index(q, box.size);
      if (there > kPieceMargin + 1 || !(there < d[i] - 1e-4f)) continue;
      d[i] = there, from[i] = f;
      queue.push_back(static_cast<std::int32_t>(i));
    }
  }
  return d;
}

}  // namespace

std::vector<float> without_piece(const PieceBox& box) {
  // Voxels. kEmpty: largest new distance. Air samples get new distances only where to_piece <= to_body + kClose.
  constexpr float kEmpty = Sweep::kInner, kClose = 0.25;
  const std::vector<float> to_body = distances_to(false, box), to_piece = distances_to(true, box);
  std::vector<float> after = box.distance;
  for (std::size_t i = 0; i < after.size(); ++i) {
    const bool air_it_made = after[i] >= 0 && to_piece[i] <= to_body[i] + kClose && to_piece[i] <= kPieceMargin;
    if (box.loose[i] != 0 || air_it_made) after[i] = std::max(after[i], std::min(to_body[i], kEmpty));
  }
  return after;
}

}  // namespace typodont::haptics
