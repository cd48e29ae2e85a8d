// Cuts a mesh by moving the vertices that are inside the head (paper S4 in docs/papers.md, section 3). Additions to the
// paper: the mesh is refined first, vertices move in a direction that stays inside the solid, and slivers are repaired
// afterwards.
#pragma once

#include <memory>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/dense_tissue.h"
#include "haptics/mesh/crossing.h"
#include "haptics/mesh/editable_mesh.h"

namespace typodont::haptics::vertex {

/// Parameters of a cut, with their reasons. Lengths are ratios to the edge length of the cut surface, which depends on
/// the head.
struct CutParameters {
  // Longest edge; a longer edge is split (Botsch & Kobbelt 2004).
  static constexpr double longest = 4.0 / 3;
  static constexpr double shortest = 0.35;  // shortest edge; a shorter edge is collapsed
  // Longest step of the head. It is so short that no face rotates far in one step.
  static constexpr double step = 0.5;
  // Largest displacement of a vertex in one step. A vertex that would move farther belongs to another wall, and does
  // not move.
  static constexpr double farthest = 3;
  // smallest cosine between the normals of a face before and after a step
  static constexpr double least_turn = 0.2;
  // Exception for faces that end parallel to the head: if the cosine between the face's normal and the reversed normal
  // of the head is above this limit, the face may rotate farther.
  static constexpr double faces_head = 0.3;
  // limit of the cosine between the normals of two faces that share a vertex; above it, the faces are not tested for
  // intersection
  static constexpr double same_way = 0.6;
  // limit of the ratio of a triangle's height to its longest edge; a flatter triangle is a sliver
  static constexpr double flattest = 0.12;
  // m, tolerance: a vertex that overlaps the head by less than this counts as on its surface
  static constexpr double overlap = 1e-10;
  // smallest cosine between the normals of two faces whose common edge may be flipped
  static constexpr double same_plane = 0.9;
  // Smallest cosine between the normals of a face before and after the repair of a sliver.
  static constexpr double least_turn_in_mending = 0.5;
  // largest change of volume when a vertex inside the head is merged into a neighbour, as a ratio to edge³
  static constexpr double most_given = 0.2;
  // largest change of volume when a sliver is repaired, as a ratio to edge³
  static constexpr double most_volume = 0.02;
};

/// The tissue labels of the volume before the first cut; null if there is only one tissue.
using SharedLabels = std::shared_ptr<const DenseTissue>;

struct CutDone {
  PerTissue removed{};   // m³, removed volume of each tissue
  bool changed = false;  // true if the mesh has changed
  bool held = false;     // true if some vertices had to stay inside the head, because of a thin wall or an open border
};

/// Cuts meshes. Memory is allocated only in the constructor. Equal input gives equal results.
class MeshCutter {
 public:
  MeshCutter() = default;
  /// Allocates the buffers; `mesh` determines their sizes.
  MeshCutter(const mesh::EditableMesh& mesh, SharedLabels labels);

  /// Moves the head from A to B in straight steps and cuts the mesh. At A the head must not overlap tissue. `edge`:
  /// edge length of the cut surface, m.
  CutDone cut(mesh::EditableMesh& mesh, const VertexHead& head, const Pose& X_WA, const Pose& X_WB,
              double edge) noexcept;
  /// Cuts with the algorithm as printed in paper S4: vertices inside the head at B move away from its centre or axis.
  /// No face is split or repaired.
  CutDone cut_as_printed(mesh::EditableMesh& mesh, const VertexHead& head, const Pose& X_WB) noexcept;

 private:
  struct Moved {
    mesh::Index v;
    mesh::Vertex before;
    dvec3 to;
    bool stays;
  };
  struct Affected {
    mesh::Index f;
    double volume6;  // m³, six times the volume of the tetrahedron formed by the face and the head's centre, with sign
    dvec3 normal;    // normal of the face; its length is twice the face's area
  };
  /// A head at a given pose.
  struct Placed {
    const VertexHead& head;
    dvec3 p;
    glm::dmat3 R_WT, R_TW;
    dvec3 to_tool(const dvec3& p_W) const noexcept { return head.is_ball() ? p_W - p : R_TW * (p_W - p); }
    double distance(const dvec3& p_W) const noexcept { return head.distance(to_tool(p_W)); }
    double distance(const dvec3& p_W, dvec3& n_W) const noexcept {
      const double d = head.distance(to_tool(p_W), n_W);
      if (!head.is_ball()) n_W = R_WT * n_W;
      return d;
    }
  };

  Placed place(const VertexHead& head, const Pose& X) const noexcept;
  void step(mesh::EditableMesh& mesh, const Placed& head, double edge, CutDone& done) noexcept;
  void gather(const mesh::EditableMesh& mesh, const Placed& head, double margin) noexcept;
  void sort_near() noexcept;
  void refine(mesh::EditableMesh& mesh, const Placed& head, double edge, CutDone& done) noexcept;
  void find_inside(const mesh::EditableMesh& mesh, const Placed& head, double edge, CutDone& done) noexcept;
  bool push_direction(const mesh::EditableMesh& mesh, const Placed& head, mesh::Index v, const dvec3& n, double depth,
                      dvec3& to) const noexcept;
  void collect_affected(const mesh::EditableMesh& mesh, const Placed& head) noexcept;
  void keep_unfolded(mesh::EditableMesh& mesh, const Placed& head) noexcept;
  void prevent_intersection(mesh::EditableMesh& mesh, const Placed& head, double edge) noexcept;
  void list_balls(const mesh::EditableMesh& mesh) noexcept;
  mesh::Index crossed_near(const mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  bool hold_back(mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  void account(mesh::EditableMesh& mesh, const Placed& head, CutDone& done) noexcept;
  void repair_slivers(mesh::EditableMesh& mesh, const Placed& head, double edge, CutDone& done) noexcept;
  bool collapse_edge(mesh::EditableMesh& mesh, const Placed& head, mesh::Index f, int i, bool keeps_first, double edge,
                     double most_volume, CutDone& done) noexcept;
  bool merge_into_neighbour(mesh::EditableMesh& mesh, const Placed& head, mesh::Index v, double edge,
                            CutDone& done) noexcept;
  bool turn(mesh::EditableMesh& mesh, mesh::Index f, int i, double edge, CutDone& done) noexcept;
  Tissue tissue_under(const mesh::EditableMesh& mesh, mesh::Index f) const noexcept;
  bool see_vertex(mesh::Index v) noexcept {
    if (vertex_seen_[v] == look_) return false;
    vertex_seen_[v] = look_;
    return true;
  }
  bool see_face(mesh::Index f) noexcept {
    if (face_seen_[f] == look_) return false;
    face_seen_[f] = look_;
    return true;
  }

  SharedLabels labels_;
  std::uint32_t look_ = 0;
  // for each vertex or face: number of the last search that visited it
  std::vector<std::uint32_t> vertex_seen_, face_seen_;
  std::vector<std::uint32_t> place_of_;  // for each vertex that moves in the present step: its index in moved_
  std::uint32_t edge_look_ = 0;
  // for each vertex: number of the last search in which one of its faces faced away from the head
  std::vector<std::uint32_t> edge_seen_;
  std::vector<mesh::Index> near_, sorted_, suspects_;
  std::vector<float> ball_x_, ball_y_, ball_z_, ball_r_;  // m, bounding balls of the faces in near_
  // indices into near_ of the faces whose bounding balls overlap the bounding ball of the face that is being tested
  std::vector<std::uint32_t> overlapping_;
  std::vector<Moved> moved_;
  std::vector<Affected> affected_;
  bool thin_ = false;  // true if a face near the head faces away from it (thin wall or undercut)
};

/// Returns six times the signed volume of the tetrahedron formed by a triangle and a point.
inline double volume6(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& p) noexcept {
  return glm::dot(a - p, glm::cross(b - p, c - p));
}

}  // namespace typodont::haptics::vertex
