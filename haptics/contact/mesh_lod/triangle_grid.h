// The triangles of one level of detail, with searches for near faces, distance and inside.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/voxels.h"
#include "haptics/contact/looks.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh_lod {

/// A triangle; m, frame W.
struct Face {
  dvec3 a, b, c;
  Tissue tissue = Tissue::kAir;
  // For the edges ab, bc, ca: tissue of the adjacent face if it differs from this face's tissue; otherwise kAir.
  std::array<Tissue, 3> across{};
  // Adjacent face at each edge; ~0: none or several. hollow_front, hollow_back: bit k is set if the surface at edge k
  // is flat or concave, seen from the front or back, so that the face's plane is also valid beyond the edge.
  std::array<std::uint32_t, 3> beyond{~0U, ~0U, ~0U};
  std::uint8_t hollow_front = 0, hollow_back = 0;

  dvec3 corner(int i) const noexcept { return i == 0 ? a : i == 1 ? b : c; }
  /// Normal of the face; its length is twice the face's area; zero: degenerate face.
  dvec3 normal() const noexcept { return glm::cross(b - a, c - a); }
};

/// Point of a face nearest to a given point. Exact also for slivers, because their edges are used.
struct OnFace {
  dvec3 p{0};
  int edge = -1;        // edge on which the point lies: 0 ab, 1 bc, 2 ca; -1: none
  bool corner = false;  // true: the point is an end of the edge
};
OnFace nearest_on(const Face& face, const dvec3& p) noexcept;
// Squared sine of an angle of a face; below this, the face is a sliver, so only its edges are used.
inline constexpr double kSliver = 1e-12;

/// A grid of cells over the triangles of a mesh. Built at set-up or by the carver; queries never allocate.
class TriangleGrid {
 public:
  TriangleGrid() = default;
  /// `part`: the mesh is a part of a larger one, which continues beyond its open edges.
  explicit TriangleGrid(const TissueMesh& mesh, bool part = false);

  std::size_t size() const noexcept { return faces_.size(); }
  const Face& face(std::uint32_t i) const noexcept { return faces_[i]; }

  /// Calls use(index) once for each face whose box overlaps the box lo..hi.
  template <class Use>
  void for_near(const dvec3& lo, const dvec3& hi, Use&& use) const noexcept;
  /// Returns true if for_near_blocks() can be used instead of for_near().
  bool has_blocks() const noexcept { return !blocks_.empty(); }
  /// Calls use() for the same faces as for_near(), in another order. Faster for many faces (99.9 % of a round bur's
  /// ticks in a cavity take at most 360 instead of 590 µs), slower for few faces in a large mesh.
  template <class Use>
  void for_near_blocks(const dvec3& lo, const dvec3& hi, Use&& use) const noexcept;

  /// Bounding box of a face, m from origin().
  struct Box {
    glm::vec3 lo{0}, hi{0};
  };
  const Box& box(std::uint32_t i) const noexcept { return boxes_[i]; }
  const dvec3& origin() const noexcept { return origin_; }
  static constexpr float kBoxRounding = 1e-7f;  // m, larger than the rounding error of a box
  /// Returns false if the box of face i is farther than `most` (m) from p.
  bool box_within(std::uint32_t i, const dvec3& p, double most) const noexcept {
    const glm::vec3 q(p - origin_), off = q - glm::clamp(q, boxes_[i].lo, boxes_[i].hi);
    const float far = static_cast<float>(most) + kBoxRounding;
    return glm::dot(off, off) <= far * far;
  }
  /// Edge length of a grid cell, m: about 1.5 mean edges of the mesh.
  double cell() const noexcept { return cell_; }

  struct Nearest {
    bool found = false;
    std::uint32_t face = 0;
    dvec3 p{0};           // m, nearest point of the surface
    double distance = 0;  // m, distance of the surface from the given point
  };
  /// Surface point nearest to p within `most` (m).
  Nearest nearest(const dvec3& p, double most) const noexcept;

  /// Winding number of the surface around p × 6, by rays along the axes: 6 inside a closed mesh, 0 outside.
  int winding_sixths(const dvec3& p) const noexcept;
  /// Returns true if p is inside the mesh. For a part of a mesh, the nearest face decides.
  bool inside(const dvec3& p) const noexcept;

 private:
  glm::ivec3 cell_of(const glm::vec3& p) const noexcept {
    // Truncation is faster than floor, and negative numbers are clamped to 0 anyway.
    return glm::clamp(glm::ivec3(p * inverse_), glm::ivec3(0), cells_ - 1);
  }
  std::size_t index(const glm::ivec3& i) const noexcept { return voxel_index(i, cells_); }
  /// Index in the mesh of the grid's face i.
  std::uint32_t rank(std::uint32_t i) const noexcept { return rank_.empty() ? i : rank_[i]; }
  void sort_faces(const TissueMesh& mesh);
  void join_faces(const TissueMesh& mesh);
  void choose_cells(const glm::vec3& extent);

  bool part_ = false;
  // for each face: its index in the mesh; empty: the faces have the order of the mesh
  std::vector<std::uint32_t> rank_;
  std::vector<Face> faces_;
  std::vector<Box> boxes_;
  /// A group of neighbouring faces with its bounding box.
  struct Block {
    Box box;
    std::uint32_t first = 0, last = 0;  // faces from `first` to `last` - 1
  };
  std::vector<Block> blocks_;  // all groups of neighbouring faces; filled only if the mesh is a part of a larger mesh
  // index in entries_ of each cell's first face; the last element is the end
  std::vector<std::uint32_t> start_;
  std::vector<std::uint32_t> entries_;  // face indices of all cells, cell by cell
  dvec3 origin_{0};
  double cell_ = 1e-3;    // m, edge length of a cell
  float inverse_ = 1e3f;  // 1/m, reciprocal of cell_
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
          // A face that lies in several cells is passed to use() only in the first of them.
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
