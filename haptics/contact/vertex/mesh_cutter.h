// Cuts a mesh by moving the vertices that are inside the head (paper S4 in docs/papers.md, section 3). Additions to the
// paper: the mesh is refined first, vertices move in a direction that stays inside the solid, and slivers are repaired
// afterwards.
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

/// Parameters of a cut, with their reasons. Most lengths are ratios to the target edge length: the wanted length of
/// mesh edges on the cut surface, which depends on the head.
struct CutParameters {
  // Longest allowed edge, in target edge lengths; a longer edge is split (Botsch & Kobbelt 2004).
  static constexpr double longest = 4.0 / 3;
  static constexpr double shortest = 0.35;  // shortest allowed edge in target edge lengths; a shorter edge is collapsed
  // Longest motion of the head in one step of a cut, in target edge lengths. It is so short that no face rotates far in
  // one step.
  static constexpr double step = 0.5;
  // Largest displacement of a vertex in one step, in target edge lengths. A vertex that would have to move farther
  // belongs to another wall, so it is not moved at all.
  static constexpr double farthest = 3;
  // smallest allowed cosine between the normal of a face before a step and the normal of this face after the step
  static constexpr double least_turn = 0.2;
  // Exception to `least_turn`: a face may rotate farther if it faces the head after the step. It faces the head if the
  // cosine between the face's normal and the reversed normal of the head is at least this limit.
  static constexpr double faces_head = 0.3;
  // Two faces that share a vertex face the same way if the cosine between their normals is above this limit. They are
  // tested for intersection only if their angles at the common vertex overlap, seen along the normal of one of them.
  static constexpr double same_way = 0.6;
  // Two faces that share an edge count as intersecting if the cosine between their normals is below this limit. Then
  // they lie on each other without any gap, and a later cut could push parts of one face through the other.
  static constexpr double flat_fold = -(1 - 1e-6);
  // Limit of the ratio of a triangle's height to its longest edge. A triangle with a smaller ratio is a sliver.
  static constexpr double flattest = 0.12;
  // Length limit, in target edge lengths. An edge shorter than this may be collapsed even if a face next to it keeps a
  // bad shape.
  static constexpr double tiny = 0.1;
  // Smallest allowed area of a face after an edge is collapsed, divided by half the square of the target edge length.
  static constexpr double least_area = 1e-6;
  // Longest allowed edge after a vertex was merged into a neighbour, in target edge lengths. The next cut splits edges
  // longer than `longest`.
  static constexpr double longest_merged = 2;
  // Limit of the number of faces near the head, divided by the number of equilateral faces of the target edge length
  // that would cover the head's surface. At this limit, edges are no longer split. In a usual
  // cut, the ratio is about two. It gets larger only at the rim of a membrane, where each split makes further splits
  // necessary.
  static constexpr double most_faces = 4;
  // m, tolerance: a vertex that is less than this deep inside the head counts as lying on the head's surface
  static constexpr double overlap = 1e-10;
  // Limit for flipping the common edge of two faces: the cosine between the normal of each new face and the mean normal
  // of the two old faces (weighted by area) must be larger than this.
  static constexpr double same_plane = 0.9;
  // Smallest allowed cosine between the normal of a face before an edge is collapsed and its normal afterwards. A face
  // that faces the head (`faces_head`) may rotate farther.
  static constexpr double least_turn_in_mending = 0.5;
  // Largest allowed change of the solid's volume when a vertex inside the head is merged into a neighbour, divided by
  // the cube of the target edge length.
  static constexpr double most_given = 0.2;
  // Largest allowed change of the solid's volume when a short edge is collapsed or an edge of a sliver is flipped,
  // divided by the cube of the target edge length.
  static constexpr double most_volume = 0.02;
};

/// The tissue of every voxel of the volume before the first cut. Null if the volume contains only one tissue.
using SharedLabels = std::shared_ptr<const DenseTissue>;

struct CutDone {
  PerTissue removed{};   // m³, removed volume of each tissue
  bool changed = false;  // true if the mesh has changed
  bool held = false;     // true if some vertices had to stay inside the head, because of a thin wall or an open border
};

/// Approximate computing time in units of 10 ns. It is computed from the numbers of processed faces and vertices, and
/// not measured, so it is the same in every replay.
using Effort = std::int64_t;
inline constexpr Effort kNoLimit = std::numeric_limits<Effort>::max();

/// Estimated computing times of the loops of a cut, in the unit of Effort. They come from measurements.
struct CutCosts {
  Effort visit = 1, sort = 1;       // per face: visit in a search; sorting of the found faces
  Effort refine = 1, split = 40;    // per face near the head; per split edge
  Effort distance = 5;              // per distance between the head and a face
  Effort find = 2;                  // per face whose corners may be inside the head
  Effort distances = 3, push = 10;  // per vertex: distance from the head; target position
  Effort collect = 10;              // per moved vertex: list of the faces around it
  Effort unfold = 2, settle = 5;    // per changed face: test for folding; update of the search grid
  Effort select = 1, ball = 1;      // per face near the head: selection for the intersection test; bounding ball
  Effort select_changed = 1;        // per changed face: selection for the intersection test
  Effort test = 75, pair = 4;       // per tested face; per pair of faces
  Effort account = 2, repair = 3;   // per changed face: removed volume and tissue; search for short edges and slivers
  Effort collapse = 60;             // per attempt to collapse or flip an edge
  Effort thin_collapse = 500;       // the same if faces near the head face away from it
};
inline constexpr CutCosts kCutCosts;

/// Faces near a head that an earlier search has already found.
struct KnownFaces {
  std::span<const mesh::Index> faces;  // contains at least all faces within the distance `within` of the head at X_W
  Pose X_W;
  double within = 0;         // m, distance from the head within which all faces are known; 0: no faces are known
  std::uint64_t number = 0;  // identifies the list: two different lists have different numbers
};

/// Cuts meshes. Buffers are allocated in the constructor. The result is deterministic.
class MeshCutter {
 public:
  MeshCutter() = default;
  /// Allocates the buffers; `mesh` determines their sizes.
  MeshCutter(const mesh::EditableMesh& mesh, SharedLabels labels);

  /// Moves the head from A to B in straight steps and cuts the mesh. The head at A must not overlap the solid. `edge`:
  /// m, target edge length, that is, the wanted length of mesh edges on the cut surface.
  CutDone cut(mesh::EditableMesh& mesh, const VertexHead& head, const Pose& X_WA, const Pose& X_WB,
              double edge) noexcept;
  /// Makes the same cut as cut(), but in parts: call begin(), then work() until it returns true, then done(). Until the
  /// cut is finished, `head` must exist, and nothing else may change the mesh. work() subtracts its computing effort
  /// from `left`, and stops when `left` is not positive. Between two parts, the faces of the mesh are connected
  /// correctly, but some vertices may have moved too far. `known`: faces near the head that an earlier search found;
  /// they save a search. Neither `known` nor the division into parts changes the result.
  void begin(const VertexHead& head, const Pose& X_WA, const Pose& X_WB, double edge) noexcept;
  bool work(mesh::EditableMesh& mesh, const KnownFaces& known, Effort& left) noexcept;
  const CutDone& done() const noexcept { return done_; }
  /// Makes a cut by the algorithm that is printed in paper S4: vertices inside the head at B move away from the head's
  /// centre or axis, to the head's surface. No face is split or repaired.
  CutDone cut_as_printed(mesh::EditableMesh& mesh, const VertexHead& head, const Pose& X_WB) noexcept;

 private:
  static constexpr int kSlices = 32;
  static constexpr std::size_t kMostTogether = 64;  // largest number of distances that are computed at once

  struct Moved {
    mesh::Index v;
    mesh::Vertex before;
    dvec3 to;
    bool stays;
  };
  struct Affected {
    mesh::Index f;
    double volume6;  // m³, six times the signed volume of the tetrahedron formed by the face and the head's centre
    dvec3 normal;    // normal of the face; its length is twice the face's area
  };
  /// A face whose distance from the head decides whether it may intersect other faces.
  struct Candidate {
    mesh::Index f;
    double within;  // m, largest distance from the head at which the face matters
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
    double edge = 0;          // m, target edge length of the faces on the cut surface
    int steps = 0, step = 0;  // steps: number of straight steps of the cut; step: number of steps that have begun
  };
  /// The stages of one step of a cut, in their order, except that kSelect follows kUnfoldAgain. kDone: the whole cut is
  /// finished.
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
  /// Calls fn(i) for the indices from at_ to `count` - 1, until the computing effort left_ is used up. `cost`: effort
  /// of one call of fn. Returns true if fn was called for the last index.
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
  bool refine(mesh::EditableMesh& mesh, const Placed& head, double edge, CutDone& done) noexcept;
  bool find_inside(const mesh::EditableMesh& mesh, const Placed& head, double edge, CutDone& done) noexcept;
  bool push_direction(const mesh::EditableMesh& mesh, const Placed& head, mesh::Index v, const dvec3& n, double depth,
                      dvec3& to) const noexcept;
  void find_targets(const mesh::EditableMesh& mesh, const Placed& head, double edge, CutDone& done) noexcept;
  void collect_affected(const mesh::EditableMesh& mesh, const Placed& head, mesh::Index v) noexcept;
  bool folds(const mesh::EditableMesh& mesh, const Placed& head, const Affected& a) const noexcept;
  bool keep_unfolded(mesh::EditableMesh& mesh, const Placed& head) noexcept;
  static bool faces_core(const mesh::EditableMesh& mesh, const Placed& head, mesh::Index f) noexcept;
  void select_suspect(const mesh::EditableMesh& mesh, const Placed& head, double edge, mesh::Index f) noexcept;
  double reach_of_changes(const mesh::EditableMesh& mesh, double edge, mesh::Index f) const noexcept;
  void add_suspect(const mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  void decide_candidates(const mesh::EditableMesh& mesh, const Placed& head) noexcept;
  void test_suspect(mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  void list_balls(const mesh::EditableMesh& mesh, double edge) noexcept;
  void list_crowd(const mesh::EditableMesh& mesh) noexcept;
  void update_crowd(const mesh::EditableMesh& mesh, mesh::Index v) noexcept;
  mesh::Index crossed_near(const mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  bool intersect(const mesh::EditableMesh& mesh, const mesh::Corners& a, const dvec3& n, mesh::Index g) const noexcept;
  bool hold_back(mesh::EditableMesh& mesh, mesh::Index f) noexcept;
  void account(mesh::EditableMesh& mesh, const Placed& head, const Affected& a, CutDone& done) noexcept;
  void repair_sliver(mesh::EditableMesh& mesh, const Placed& head, mesh::Index f, double edge, CutDone& done) noexcept;
  bool collapse_edge(mesh::EditableMesh& mesh, const Placed& head, mesh::Index f, int i, bool keeps_first, double edge,
                     double longest, double most_volume, CutDone& done) noexcept;
  bool merge_into_neighbour(mesh::EditableMesh& mesh, const Placed& head, mesh::Index v, double edge,
                            CutDone& done) noexcept;
  bool turn(mesh::EditableMesh& mesh, mesh::Index f, int i, double edge, CutDone& done) noexcept;
  Tissue tissue_under(const mesh::EditableMesh& mesh, mesh::Index f) const noexcept;
  /// Returns the slice of a ball whose centre has this coordinate (m) on the axis of the slices.
  int slice_at(float x) const noexcept {
    return static_cast<int>(std::clamp((x - slice_lo_) * slices_per_m_, 0.0f, static_cast<float>(kSlices - 1)));
  }
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
  // for each vertex and each face: number of the search (look_) that last visited it
  std::vector<std::uint32_t> vertex_seen_, face_seen_;
  std::vector<std::uint32_t> place_of_;  // for each vertex that moves in the present step: its index in moved_
  std::uint32_t edge_look_ = 0;
  // for each vertex: number of the last round of the intersection test (edge_look_) in which a face around the vertex
  // faced away from the head
  std::vector<std::uint32_t> edge_seen_;
  std::vector<mesh::Index> near_, sorted_, suspects_;
  HeadDistances distances_{kMostTogether};           // points whose distances from the head are computed together
  std::array<Candidate, kMostTogether> candidates_;  // for each point in distances_ during the selection: its face
  // m, centres and radii of the bounding balls of the faces in near_, sorted into slices
  std::vector<float> ball_x_, ball_y_, ball_z_, ball_r_;
  std::vector<std::uint32_t> ball_at_;  // for each ball: index of its face in near_
  int slice_axis_ = 0;                  // axis along which the balls are sorted into slices
  float slice_lo_ = 0, slices_per_m_ = 0;
  float widest_ = 0;  // m, largest radius of a ball in the slices
  // index of the first ball of each slice; the last elements: index of the first large ball, and number of balls
  std::array<std::uint32_t, kSlices + 2> slice_start_{};
  // balls that overlap the bounding ball of the face under test
  std::vector<std::uint32_t> overlapping_;
  // The corners of the faces in near_, in the order of the bounding balls. The table is filled only if very many
  // bounding balls overlap. This happens at the rim of a hole through a sheet. A cut cannot remove the membrane that
  // remains between the two sides of the sheet, so many tiny faces collect there.
  mesh::TriangleTable crowd_;
  bool crowded_ = false;                // true if crowd_ was filled in this round of the intersection test
  std::vector<std::uint32_t> slot_of_;  // for each face: its index in crowd_; valid only if the face is in crowd_
  // for each face: number of the last round of the intersection test in which the face was tested and crossed no other
  // face
  std::vector<std::uint32_t> tested_in_;
  std::vector<Moved> moved_;
  std::vector<Affected> affected_;
  bool thin_ = false;  // true if a face near the head faces away from it (thin wall or undercut)
  // The next members are the state of the cut in progress. The cut may be made in several parts, between which the
  // state is kept.
  Job job_;
  Placed head_;                            // the head at its pose in the present step of the cut
  mesh::EditableMesh::NearSearch search_;  // search for the faces near head_
  double margin_ = 0;                      // m, distance from the head within which faces are gathered
  bool takes_known_ = false;               // true if the faces come from the list of an earlier search (number known_)
  std::uint64_t known_ = 0;
  Stage stage_ = Stage::kDone;
  Effort left_ = 0;               // computing effort that the present call of work() may still spend
  std::size_t at_ = 0;            // index of the face or vertex at which the present stage of the cut continues
  std::size_t looking_away_ = 0;  // number of faces that face away from the head; suspects_ begins with them
  bool held_ = false;             // true if vertices were moved back in this round of the intersection test
  int rounds_ = 0;                // number of rounds of the intersection test in this step
  // true if vertices were moved back in this round of keep_unfolded(), which repairs folded faces
  bool unfold_held_ = false;
  int unfold_rounds_ = 0;  // number of rounds of keep_unfolded() in this step of the cut
  CutDone done_;
};

/// Returns six times the signed volume of the tetrahedron formed by a triangle and a point.
inline double volume6(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& p) noexcept {
  return glm::dot(a - p, glm::cross(b - p, c - p));
}

}  // namespace typodont::haptics::vertex
