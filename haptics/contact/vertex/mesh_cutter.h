// Moves the vertices of a mesh out of the head (paper S4 in docs/papers.md, section 3). Beyond the paper, it splits
// long edges first, keeps vertices inside the solid, and repairs slivers.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/contact/vertex/head_distances.h"
#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/dense_tissue.h"
#include "haptics/mesh/crossing.h"
#include "haptics/mesh/editable_mesh.h"

namespace typodont::haptics::vertex {

/// Most lengths are ratios to the target edge length of the mesh.
struct CutParameters {
  // In target edge lengths; longer edges are split before the cut (Botsch & Kobbelt 2004).
  static constexpr double longest = 4.0 / 3;
  static constexpr double shortest = 0.35;  // in target edge lengths; shorter edges are collapsed
  // In target edge lengths, motion of the head per step; short, so that no face turns far.
  static constexpr double step = 0.5;
  // In target edge lengths, largest motion of a vertex per step; a vertex that needs more belongs to another wall.
  static constexpr double farthest = 3;
  // smallest cosine between a face's normals before and after a step
  static constexpr double min_turn = 0.2;
  // A face may turn farther than `min_turn` if the cosine between its normal and the head's reversed normal is at least
  // this.
  static constexpr double faces_head = 0.3;
  // Cosine between normals above which two faces with a common vertex have the same direction. Such faces are tested
  // for intersection only if their angles at the vertex overlap, seen along a normal.
  static constexpr double same_way = 0.6;
  // Cosine between normals below which two faces at a common edge count as intersecting, because one lies on the other.
  static constexpr double flat_fold = -(1 - 1e-6);
  // a face whose height divided by its longest edge is below this is a sliver
  static constexpr double flattest = 0.12;
  // In target edge lengths; a shorter edge may collapse even if this leaves a badly shaped face.
  static constexpr double tiny = 0.1;
  // smallest area of a face after a collapse divided by half the squared target edge length
  static constexpr double min_area = 1e-6;
  // In target edge lengths, longest edge after a merge of vertices; the next cut splits edges above `longest`.
  static constexpr double longest_merged = 2;
  // Number of faces near the head divided by the number of equilateral faces that would cover the head. Above this, no
  // edge is split. Usually about two; more only at the rim of a membrane.
  static constexpr double max_faces = 4;
  // m; a vertex up to this deep inside the head still counts as on the head's surface
  static constexpr double overlap = 1e-10;
  // Smallest cosine between the new normals and the old mean normal (weighted by area) that allows to flip an edge.
  static constexpr double same_plane = 0.9;
  // Smallest cosine between a face's normals before and after a collapse. Faces directed towards the head
  // (`faces_head`) may turn farther.
  static constexpr double min_turn_in_mending = 0.5;
  // In cubes of the target edge length; a merge of two vertices that changes the volume by more than this is refused.
  static constexpr double max_given = 0.2;
  // Largest change of the mesh's volume by a collapse or flip, in cubes of the target edge length.
  static constexpr double max_volume = 0.02;
};

/// Tissue of each voxel before all cuts; null: there is only one tissue.
using SharedLabels = std::shared_ptr<const DenseTissue>;

struct CutDone {
  PerTissue removed{};   // m³, removed volume of each tissue
  bool changed = false;  // true if the mesh has changed
  bool held = false;     // true: some vertices inside the head could not move
};

/// Computing effort in units of 10 ns, computed from numbers of faces and vertices, so that a replay has equal values.
using Effort = std::int64_t;
inline constexpr Effort kNoLimit = std::numeric_limits<Effort>::max();

/// Measured costs of a cut's operations, in units of Effort.
struct CutCosts {
  Effort visit = 1, sort = 1;       // costs per face: to visit it in the search; to sort it
  Effort refine = 1, split = 40;    // cost per face near the head; cost per split edge
  Effort distance = 5;              // cost per distance between the head and a face
  Effort find = 2;                  // cost per face whose corners may be inside the head
  Effort distances = 3, push = 10;  // costs per vertex: distance from the head; target position
  Effort collect = 10;              // cost per moved vertex: collecting the faces around it
  Effort unfold = 2, settle = 5;    // costs per changed face: test for folding; update of the search grid
  Effort select = 1, ball = 1;      // costs per near face: selection for the intersection test; its bounding ball
  Effort select_changed = 1;        // cost per changed face: selection for the intersection test
  Effort test = 75, pair = 4;       // costs of the intersection test: per face; per pair of faces
  Effort account = 2, repair = 3;   // costs per changed face: sum of volume and tissue; mending short edges and slivers
  Effort collapse = 60;             // cost per attempt to collapse or flip an edge
  // cost per attempt to collapse or flip an edge, if some faces are directed away from the head
  Effort thin_collapse = 500;
};
inline constexpr CutCosts kCutCosts;

/// Faces near the head that an earlier search has found.
struct KnownFaces {
  std::span<const mesh::Index> faces;  // faces near the head, see `within`
  Pose X_W;
  double within = 0;         // m; `faces` contains all faces nearer to the head than this; 0: `faces` is not valid
  std::uint64_t number = 0;  // number of the list, different for every list
};

/// Cuts a mesh. Allocates in the constructor only. Deterministic.
class MeshCutter {
 public:
  MeshCutter() = default;
  /// Allocates the buffers; `mesh` determines their sizes.
  MeshCutter(const mesh::EditableMesh& mesh, SharedLabels labels);

  /// Cuts from pose A, where the head overlaps nothing, to B in straight steps. `edge`: m, target edge length.
  CutDone cut(mesh::EditableMesh& mesh, const VertexHead& head, const Pose& X_WA, const Pose& X_WB,
              double edge) noexcept;
  /// Makes a cut in parts: begin(), work() until it returns true, done(). Meanwhile nothing else may change the mesh.
  /// work() uses up the computing effort `left`. `known`: faces found earlier, to save a search. The result does not
  /// depend on `left` or `known`.
  void begin(const VertexHead& head, const Pose& X_WA, const Pose& X_WB, double edge) noexcept;
  bool work(mesh::EditableMesh& mesh, const KnownFaces& known, Effort& left) noexcept;
  const CutDone& done() const noexcept { return done_; }
  /// Cuts exactly as paper S4 describes: moves vertices away from the head's centre or axis to its surface, without
  /// splits or repairs.
  CutDone cut_as_printed(mesh::EditableMesh& mesh, const VertexHead& head, const Pose& X_WB) noexcept;

 private:
  static constexpr int kSlices = 32;
  static constexpr std::size_t kMaxTogether = 64;  // number of distances that are computed together

  struct Moved {
    mesh::Index v;
    mesh::Vertex before;
    dvec3 to;
    bool stays;
  };
  struct Affected {
    mesh::Index f;
    double volume6;  // m³ × 6, volume of the tetrahedron with the head's centre
    dvec3 normal;    // normal whose length is twice the face's area
  };
  /// A face that may intersect another face. It is tested only if its distance from the head is at most `within`.
  struct Candidate {
    mesh::Index f;
    double within;  // m, the face is tested if its distance from the head is smaller
  };
  /// A head at a given pose.
  struct Placed {
    const VertexHead* head = nullptr;
    Pose X_W;
    glm::dmat3 R_WT{1}, R_TW{1};
    dvec3 to_tool(const dvec3& p_W) const noexcept { return head->is_ball() ? p_W - X_W.p : R_TW * (p_W - X_W.p); }
    double distance(const dvec3& p_W) const noexcept { return head->distance(to_tool(p_W)); }
    double distance(const dvec3& p_W, dvec3& n_W) const noexcept {
      const double d = head->distance(to_tool(p_W), n_W);
      if (!head->is_ball()) n_W = R_WT * n_W;
      return d;
    }
  };

  /// The cut that begin() started.
  struct Job {
    const VertexHead* head = nullptr;
    Pose X_WA, X_WB;
    double edge = 0;          // m, target edge length
    int steps = 0, step = 0;  // total number of steps, and number of steps begun so far
  };
  /// Stages of a step of the cut, in this order; kUnfoldAgain, if needed, leads back to kSelect. kDone: cut complete.
  enum class Stage : std::uint8_t {
    kNextStep,
    kSearch,
    kRefine,
    kFind,
    kCollect,
    kUnfold,
    kSettle,
    kSelect,
    kSelectChanged,
    kTest,
    kUnfoldAgain,
    kAccount,
    kMerge,
    kRepair,
    kDone
  };

  Placed place(const VertexHead& head, const Pose& X) const noexcept;
  void run_stage(mesh::EditableMesh& mesh, const KnownFaces& known) noexcept;
  /// Calls fn(i) for i from at_ to `count` - 1 while computing effort is left; each call costs `cost`. Returns true if
  /// all calls were made.
  template <class Fn>
  bool each(std::size_t count, Effort cost, Fn&& fn) noexcept {
    for (; at_ < count; ++at_) {
      if (left_ <= 0) return false;
      left_ -= cost;
      fn(at_);
    }
    at_ = 0;
    return true;
  }
  void go_to(Stage stage) noexcept { stage_ = stage, at_ = 0; }
  void begin_search(const Placed& head, double margin) noexcept;
  void add_if_near(const mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  bool covers(const KnownFaces& known) const noexcept;
  bool gather_in_part(const mesh::EditableMesh& mesh, const KnownFaces& known) noexcept;
  void sort_near() noexcept;
  bool refine(mesh::EditableMesh& mesh) noexcept;
  bool find_inside(const mesh::EditableMesh& mesh) noexcept;
  bool push_direction(const mesh::EditableMesh& mesh, mesh::Index v, const dvec3& n, double depth,
                      dvec3& to) const noexcept;
  void find_targets(const mesh::EditableMesh& mesh) noexcept;
  void collect_affected(const mesh::EditableMesh& mesh, mesh::Index v) noexcept;
  bool folds(const mesh::EditableMesh& mesh, const Affected& a) const noexcept;
  bool keep_unfolded(mesh::EditableMesh& mesh) noexcept;
  bool faces_core(const mesh::EditableMesh& mesh, mesh::Index f) const noexcept;
  void select_suspect(const mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  void add_suspect(const mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  void decide_candidates(const mesh::EditableMesh& mesh) noexcept;
  void test_suspect(mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  void list_balls(const mesh::EditableMesh& mesh) noexcept;
  void list_crowd(const mesh::EditableMesh& mesh) noexcept;
  void update_crowd(const mesh::EditableMesh& mesh, mesh::Index v) noexcept;
  mesh::Index crossed_near(const mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  bool intersect(const mesh::EditableMesh& mesh, const mesh::Corners& a, const dvec3& n, mesh::Index g) const noexcept;
  bool hold_back(mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  void account(mesh::EditableMesh& mesh, const Affected& a) noexcept;
  void repair_sliver(mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  bool collapse_edge(mesh::EditableMesh& mesh, mesh::Index f, int i, bool keeps_first, double longest,
                     double max_volume) noexcept;
  bool merge_into_neighbour(mesh::EditableMesh& mesh, mesh::Index v) noexcept;
  bool turn(mesh::EditableMesh& mesh, mesh::Index f, int i) noexcept;
  Tissue tissue_under(const mesh::EditableMesh& mesh, mesh::Index f) const noexcept;
  /// Index of the slice that contains a bounding ball. `x`: m, coordinate of its centre along slice_axis_.
  int slice_at(float x) const noexcept {
    return static_cast<int>(std::clamp((x - slice_lo_) * slices_per_m_, 0.0f, static_cast<float>(kSlices - 1)));
  }
  bool see_vertex(mesh::Index v) noexcept {
    if (vertex_seen_[v] == search_number_) return false;
    vertex_seen_[v] = search_number_;
    return true;
  }
  bool see_face(mesh::Index f) noexcept {
    if (face_seen_[f] == search_number_) return false;
    face_seen_[f] = search_number_;
    return true;
  }

  SharedLabels labels_;
  std::uint32_t search_number_ = 0;
  // for each vertex and each face: number of the search (search_number_) that last visited it
  std::vector<std::uint32_t> vertex_seen_, face_seen_;
  std::vector<std::uint32_t> place_of_;  // for each vertex visited in this step: its index in moved_
  std::uint32_t edge_search_number_ = 0;
  // for each vertex: value of edge_search_number_ when add_suspect() last added one of the vertex's faces
  std::vector<std::uint32_t> edge_seen_;
  std::vector<mesh::Index> near_, sorted_, suspects_;
  HeadDistances distances_{kMaxTogether};           // buffer for distances that are computed together
  std::array<Candidate, kMaxTogether> candidates_;  // the faces whose distances are computed in distances_
  // Bounding balls (m) of the faces in near_, sorted by slices.
  std::vector<float> ball_x_, ball_y_, ball_z_, ball_r_;
  std::vector<std::uint32_t> ball_at_;  // for each ball: index of its face in near_
  int slice_axis_ = 0;                  // axis along which the balls are sorted into slices
  float slice_lo_ = 0, slices_per_m_ = 0;
  float widest_ = 0;  // m, largest radius of the balls in the slices
  // index of each slice's first ball; then index of the first ball larger than widest_, and number of balls
  std::array<std::uint32_t, kSlices + 2> slice_start_{};
  // bounding balls that overlap the tested face's ball
  std::vector<std::uint32_t> overlapping_;
  // Corners of the faces in near_, in the order of the balls. Filled only if very many bounding balls overlap, as at
  // the rim of a hole, where a thin membrane collects tiny faces.
  mesh::TriangleTable crowd_;
  bool crowded_ = false;                // true: crowd_ contains the faces that are in near_ now
  std::vector<std::uint32_t> slot_of_;  // for each face in near_: its index in crowd_
  // for each face: last round in which it was tested without an intersection
  std::vector<std::uint32_t> tested_in_;
  std::vector<Moved> moved_;
  std::vector<Affected> affected_;
  bool thin_ = false;  // true: some face is directed away from the head (thin wall)
  // The cut that is being made in parts.
  Job job_;
  Placed head_;                            // the head in this step
  mesh::EditableMesh::NearSearch search_;  // search for the faces near head_
  double margin_ = 0;                      // m, distance from the head within which faces are collected
  bool takes_known_ = false;               // true: near_ is collected from the KnownFaces with the number known_
  std::uint64_t known_ = 0;
  Stage stage_ = Stage::kDone;
  Effort left_ = 0;               // computing effort that remains for this call of work()
  std::size_t at_ = 0;            // index of the face or vertex with which the current stage continues
  std::size_t looking_away_ = 0;  // number of faces directed away from the head; they come first in suspects_
  bool held_ = false;             // true: vertices were moved back in this round
  int rounds_ = 0;                // number of rounds of the intersection test in this step
  // true: this round of keep_unfolded() moved vertices back
  bool unfold_held_ = false;
  int unfold_rounds_ = 0;  // number of rounds of keep_unfolded() in this step
  CutDone done_;
};

/// Normal of a triangle; its length is twice the triangle's area.
inline dvec3 normal2(const dvec3& a, const dvec3& b, const dvec3& c) noexcept {
  return glm::cross(b - a, c - a);
}
inline dvec3 normal2(const mesh::EditableMesh& mesh, mesh::Index f) noexcept {
  return normal2(mesh.point(f, 0), mesh.point(f, 1), mesh.point(f, 2));
}

/// Six times the volume of the tetrahedron a, b, c, p, m³.
inline double volume6(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& p) noexcept {
  return glm::dot(a - p, glm::cross(b - p, c - p));
}

}  // namespace typodont::haptics::vertex
