// One level's triangles: near a point, distance, inside.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "haptics/contact/looks.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh_lod {

/// SI, W.
struct Face {
  dvec3 a, b, c;
  Tissue tissue = Tissue::kAir;
  // Across ab, bc, ca: tissue; kAir: the same, or no face.
  std::array<Tissue, 3> across{};
  // Across each edge; ~0: none, or several. Bit k of `hollow_front`, `hollow_back`: flat or concave there from front or
  // back, so this plane also holds beyond the edge.
  std::array<std::uint32_t, 3> beyond{~0U, ~0U, ~0U};
  std::uint8_t hollow_front = 0, hollow_back = 0;

  dvec3 corner(int i) const noexcept { return i == 0 ? a : i == 1 ? b : c; }
  /// Twice the area long; zero: degenerate.
  dvec3 normal() const noexcept { return glm::cross(b - a, c - a); }
};

/// Nearest to p. Exact for slivers, by their edges.
struct OnFace {
  dvec3 p{0};
  int edge = -1;        // ab, bc or ca; -1: interior
  bool corner = false;  // an end of the edge
};
OnFace nearest_on(const Face& face, const dvec3& p) noexcept;
/// On the border.
OnFace nearest_on_edges(const Face& face, const dvec3& p) noexcept;
// squared sine of an angle, below which only edges count
inline constexpr double kSliver = 1e-12;
/// On a–b.
inline dvec3 nearest_on_segment(const dvec3& a, const dvec3& b, const dvec3& p) noexcept {
  const dvec3 ab = b - a;
  const double along = glm::dot(p - a, ab), square = glm::dot(ab, ab);
  return square > 0 ? a + std::clamp(along / square, 0.0, 1.0) * ab : a;
}

/// Built at set-up or by the carver; queries never allocate.
class TriangleGrid {
 public:
  TriangleGrid() = default;
  /// `part`: of a mesh that goes on beyond open edges.
  explicit TriangleGrid(const TissueMesh& mesh, bool part = false);

  std::size_t size() const noexcept { return faces_.size(); }
  const Face& face(std::uint32_t i) const noexcept { return faces_[i]; }
  /// Bytes, all.
  std::size_t bytes() const noexcept;

  /// use(index), once per face whose box overlaps lo..hi.
  template <class Use>
  void for_near(const dvec3& lo, const dvec3& hi, Use&& use) const noexcept;
  /// for_near_blocks() finds for_near()'s faces.
  bool has_blocks() const noexcept { return !blocks_.empty(); }
  /// for_near()'s in another order; faster for many: a round bur's 99.9 % tick in a cavity was 360 µs, not 590. Slower
  /// for few in a large mesh.
  template <class Use>
  void for_near_blocks(const dvec3& lo, const dvec3& hi, Use&& use) const noexcept;

  /// m from origin().
  struct Box {
    glm::vec3 lo{0}, hi{0};
  };
  const Box& box(std::uint32_t i) const noexcept { return boxes_[i]; }
  const dvec3& origin() const noexcept { return origin_; }
  static constexpr float kBoxRounding = 1e-7f;  // m, above a box's rounding
  /// False: farther than `most` m.
  bool box_within(std::uint32_t i, const dvec3& p, double most) const noexcept {
    const glm::vec3 q(p - origin_), off = q - glm::clamp(q, boxes_[i].lo, boxes_[i].hi);
    const float far = static_cast<float>(most) + kBoxRounding;
    return glm::dot(off, off) <= far * far;
  }
  /// m, about 1.5 mean edges.
  double cell() const noexcept { return cell_; }

  struct Nearest {
    bool found = false;
    std::uint32_t face = 0;
    dvec3 p{0};           // m, nearest point of the surface
    double distance = 0;  // m, to the surface
  };
  /// Within `most` m.
  Nearest nearest(const dvec3& p, double most) const noexcept;

  /// Rays along axes: 6 inside a closed mesh, 0 outside.
  int winding_sixths(const dvec3& p) const noexcept;
  /// Of a part, by the nearest face.
  bool inside(const dvec3& p) const noexcept;

 private:
  glm::ivec3 cell_of(const glm::vec3& p) const noexcept {
    // Truncation is faster than floor; negative numbers are clamped to 0.
    return glm::clamp(glm::ivec3(p * inverse_), glm::ivec3(0), cells_ - 1);
  }
  std::size_t index(const glm::ivec3& i) const noexcept {
    return (static_cast<std::size_t>(i.x) * static_cast<std::size_t>(cells_.y) + static_cast<std::size_t>(i.y)) *
               static_cast<std::size_t>(cells_.z) +
           static_cast<std::size_t>(i.z);
  }
  /// Of the grid's face i.
  std::uint32_t rank(std::uint32_t i) const noexcept { return rank_.empty() ? i : rank_[i]; }
  void sort_faces(const TissueMesh& mesh);
  void join_faces(const TissueMesh& mesh);
  void choose_cells(const glm::vec3& extent);

  bool part_ = false;
  // in the mesh, per face; empty: the same
  std::vector<std::uint32_t> rank_;
  std::vector<Face> faces_;
  std::vector<Box> boxes_;
  /// Neighbours with their box.
  struct Block {
    Box box;
    std::uint32_t first = 0, last = 0;  // `first` to `last` - 1
  };
  std::vector<Block> blocks_;  // blocks, if part of a mesh
  // per cell in entries_, and the end
  std::vector<std::uint32_t> start_;
  std::vector<std::uint32_t> entries_;  // per cell
  dvec3 origin_{0};
  double cell_ = 1e-3;    // m, edge length of a cell
  float inverse_ = 1e3f;  // 1/m
  glm::ivec3 cells_{0};
};

template <class Use>
void TriangleGrid::for_near(const dvec3& lo, const dvec3& hi, Use&& use) const noexcept {
  ++t_search_counts.triangles;
  if (faces_.empty()) return;
  const glm::vec3 low(lo - origin_), high(hi - origin_);
  const glm::ivec3 first = cell_of(low), last = cell_of(high);
  for (int x = first.x; x <= last.x; ++x) {
    for (int y = first.y; y <= last.y; ++y) {
      const std::size_t row = index({x, y, 0});
      for (int z = first.z; z <= last.z; ++z) {
        const std::size_t at = row + static_cast<std::size_t>(z);
        for (std::uint32_t k = start_[at]; k < start_[at + 1]; ++k) {
          const std::uint32_t i = entries_[k];
          const Box& box = boxes_[i];
          if (box.lo.x > high.x || box.lo.y > high.y || box.lo.z > high.z || box.hi.x < low.x || box.hi.y < low.y ||
              box.hi.z < low.z)
            continue;
          // In several cells: the first calls use().
          if (first != last && glm::max(cell_of(box.lo), first) != glm::ivec3(x, y, z)) continue;
          use(i);
        }
      }
    }
  }
}

template <class Use>
void TriangleGrid::for_near_blocks(const dvec3& lo, const dvec3& hi, Use&& use) const noexcept {
  ++t_search_counts.triangles;
  const glm::vec3 low(lo - origin_), high(hi - origin_);
  const auto apart = [&](const Box& box) {
    return (box.lo.x > high.x) | (box.lo.y > high.y) | (box.lo.z > high.z) | (box.hi.x < low.x) | (box.hi.y < low.y) |
           (box.hi.z < low.z);
  };
  for (const Block& block : blocks_) {
    if (apart(block.box)) continue;
    for (std::uint32_t i = block.first; i < block.last; ++i) {
      if (!apart(boxes_[i])) use(i);
    }
  }
}

}  // namespace typodont::haptics::mesh_lod
