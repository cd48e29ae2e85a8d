// Cuts a mesh with a head by moving the mesh's vertices (paper S4 in docs/papers.md, section 3), with additions: the
// mesh is refined first, vertices move in a direction that stays in the solid, and slivers are repaired afterwards.
#pragma once

#include <memory>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/dense_tissue.h"
#include "haptics/mesh/crossing.h"
#include "haptics/mesh/editable_mesh.h"

namespace typodont::haptics::vertex {

/// Parameters of a cut with their reasons. Lengths are multiples of the edge length that the head requires.
struct CutParameters {
  // Upper limit of an edge's length; a longer edge is split (Botsch & Kobbelt 2004).
  static constexpr double longest = 4.0 / 3;
  static constexpr double shortest = 0.35;  // lower limit of an edge's length; a shorter edge is collapsed
  // Length of a step of the head, as a ratio to the edge length. It is so short that no face rotates far in one step.
  static constexpr double step = 0.5;
  // Limit of a vertex's displacement in a step; a vertex that would move farther belongs to another wall.
  static constexpr double farthest = 3;
  // lower limit of the cosine between a face's normals before and after a step
  static constexpr double least_turn = 0.2;
  // Lower limit of the cosine between a face's normal and the head's normal; above this limit, the face may rotate
  // farther.
  static constexpr double faces_head = 0.3;
  // lower limit of the cosine between two faces at one vertex; above this limit, they are not tested for intersection
  static constexpr double same_way = 0.6;
  // lower limit of a triangle's height over its longest edge, as a ratio; a flatter triangle is a sliver
  static constexpr double flattest = 0.12;
  // m, limit of the overlap of a vertex that counts as lying on the head's surface
  static constexpr double overlap = 1e-10;
  // lower limit of the cosine between two faces whose common edge may be flipped
  static constexpr double same_plane = 0.9;
  // Lower limit of the cosine between a face's normals before and after the repair of a sliver.
  static constexpr double least_turn_in_mending = 0.5;
  // limit, as a ratio to edge³, of the volume that may change when a vertex that folds the surface is removed
  static constexpr double most_given = 0.2;
  // limit, as a ratio to edge³, of the volume that may change when a sliver is repaired
  static constexpr double most_volume = 0.02;
};

/// The tissue labels before the first cut; null if there is only one tissue.
using SharedLabels = std::shared_ptr<const DenseTissue>;

struct CutDone {
  PerTissue removed{};   // m³
  bool changed = false;  // the mesh changed
  bool held = false;     // vertices stayed inside the head, because of a thin wall or a border
};

/// Buffers are allocated in the constructor. Equal meshes and equal cuts give equal bits.
class MeshCutter {
 public:
  MeshCutter() = default;
  /// Allocates the buffers; `mesh` determines their sizes.
  MeshCutter(const mesh::EditableMesh& mesh, SharedLabels labels);

  /// Moves the head from A to B in straight steps. At A the head must overlap no tissue. `edge`: m, edge length of
  /// the resulting surface.
  CutDone cut(mesh::EditableMesh& mesh, const VertexHead& head, const Pose& X_WA, const Pose& X_WB,
              double edge) noexcept;
  /// The algorithm as printed in the paper: vertices inside the head at B move away from its centre or axis. It
  /// neither splits nor repairs.
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
    double volume6;  // m³, six times the signed volume between the face and the head's centre
    dvec3 normal;    // normal of the face, multiplied by twice its area
  };
  /// A head at one pose.
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
  std::vector<std::uint32_t> vertex_seen_, face_seen_;  // number of the last search that visited the vertex or face
  std::vector<std::uint32_t> place_of_;                 // for a visited vertex that moves: index in moved_
  std::uint32_t edge_look_ = 0;
  // for a vertex: the last search in which one of its faces faced away from the head
  std::vector<std::uint32_t> edge_seen_;
  std::vector<mesh::Index> near_, sorted_, suspects_;
  std::vector<float> ball_x_, ball_y_, ball_z_, ball_r_;  // m, bounding balls of the faces in near_
  std::vector<std::uint32_t> overlapping_;                // indices in near_
  std::vector<Moved> moved_;
  std::vector<Affected> affected_;
  bool thin_ = false;  // true if a face near the head faces away from the head
};

/// Six times the signed volume between a triangle and a point.
inline double volume6(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& p) noexcept {
  return glm::dot(a - p, glm::cross(b - p, c - p));
}

}  // namespace typodont::haptics::vertex
