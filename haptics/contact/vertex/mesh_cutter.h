// Moves vertices out of the head (S4 in docs/papers.md, section 3); also refines first, keeps ways inside the solid,
// and repairs slivers.
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

/// Mostly in target edge lengths, which depend on the head.
struct CutParameters {
  // Longer edges are split (Botsch & Kobbelt 2004).
  static constexpr double longest = 4.0 / 3;
  static constexpr double shortest = 0.35;  // shorter edges are collapsed
  // Head's motion per step: no face turns far.
  static constexpr double step = 0.5;
  // Vertex's motion per step; one that needs more is of another wall and stays.
  static constexpr double farthest = 3;
  // cosine of a face's normals before and after a step
  static constexpr double least_turn = 0.2;
  // A face may turn farther if its normal and the head's reversed one have at least this cosine.
  static constexpr double faces_head = 0.3;
  // Cosine above which faces at a vertex face alike; tested only if their angles overlap along a normal.
  static constexpr double same_way = 0.6;
  // Cosine below which faces at an edge intersect: they lie on each other, and could be pushed through.
  static constexpr double flat_fold = -(1 - 1e-6);
  // Height / longest edge, below which it is a sliver.
  static constexpr double flattest = 0.12;
  // Edge that may collapse even beside a bad face.
  static constexpr double tiny = 0.1;
  // Face after a collapse, in half the squared target edge.
  static constexpr double least_area = 1e-6;
  // Edge after a merge; the next cut splits those above `longest`.
  static constexpr double longest_merged = 2;
  // Faces near the head, in equilateral ones that cover it; no more splits above. Usually about two; more only at a
  // membrane's rim, where splits breed splits.
  static constexpr double most_faces = 4;
  // m inside, still on the head's surface
  static constexpr double overlap = 1e-10;
  // For a flip: cosine of new normals and the old mean (by area).
  static constexpr double same_plane = 0.9;
  // For a collapse: cosine before and after; faces towards the head (`faces_head`) may turn farther.
  static constexpr double least_turn_in_mending = 0.5;
  // Volume of a merge, in cubed target edges.
  static constexpr double most_given = 0.2;
  // Volume of a collapse or flip, in cubed target edges.
  static constexpr double most_volume = 0.02;
};

/// Before the first cut; null: one tissue.
using SharedLabels = std::shared_ptr<const DenseTissue>;

struct CutDone {
  PerTissue removed{};   // m³, removed volume of each tissue
  bool changed = false;  // true if the mesh has changed
  bool held = false;     // some had to stay inside: thin wall or open border
};

/// In 10 ns, by numbers of faces and vertices, so a replay has the same.
using Effort = std::int64_t;
inline constexpr Effort kNoLimit = std::numeric_limits<Effort>::max();

/// In Effort's unit, by measurement.
struct CutCosts {
  Effort visit = 1, sort = 1;       // per face: visit, sorting
  Effort refine = 1, split = 40;    // per face near the head; per split edge
  Effort distance = 5;              // per distance between the head and a face
  Effort find = 2;                  // per face with corners possibly inside
  Effort distances = 3, push = 10;  // per vertex: distance from the head; target position
  Effort collect = 10;              // per moved vertex: faces around
  Effort unfold = 2, settle = 5;    // per changed face: folding; grid
  Effort select = 1, ball = 1;      // per near face: selection; ball
  Effort select_changed = 1;        // per changed face: selection for the intersection test
  Effort test = 75, pair = 4;       // per tested face; per pair of faces
  Effort account = 2, repair = 3;   // per changed face: volume, tissue; short edges and slivers
  Effort collapse = 60;             // per attempt to collapse or flip an edge
  Effort thin_collapse = 500;       // the same with faces away from the head
};
inline constexpr CutCosts kCutCosts;

/// By an earlier search.
struct KnownFaces {
  std::span<const mesh::Index> faces;  // at least all within `within` of the head at X_W
  Pose X_W;
  double within = 0;         // m; 0: none
  std::uint64_t number = 0;  // different for every list
};

/// Allocates in the constructor. Deterministic.
class MeshCutter {
 public:
  MeshCutter() = default;
  /// Allocates the buffers; `mesh` determines their sizes.
  MeshCutter(const mesh::EditableMesh& mesh, SharedLabels labels);

  /// From A, without overlap, to B in straight steps. `edge`: m, target edge length.
  CutDone cut(mesh::EditableMesh& mesh, const VertexHead& head, const Pose& X_WA, const Pose& X_WB,
              double edge) noexcept;
  /// cut() in parts: begin(), work() until true, done(). Meanwhile `head` stays and nothing else changes the mesh.
  /// work() uses up `left`; between parts faces connect correctly, but vertices may be too far. `known`: saves a
  /// search. Results do not depend on parts or `known`.
  void begin(const VertexHead& head, const Pose& X_WA, const Pose& X_WB, double edge) noexcept;
  bool work(mesh::EditableMesh& mesh, const KnownFaces& known, Effort& left) noexcept;
  const CutDone& done() const noexcept { return done_; }
  /// As printed in S4: away from the centre or axis to the surface, without splits or repairs.
  CutDone cut_as_printed(mesh::EditableMesh& mesh, const VertexHead& head, const Pose& X_WB) noexcept;

 private:
  static constexpr int kSlices = 32;
  static constexpr std::size_t kMostTogether = 64;  // distances at once

  struct Moved {
    mesh::Index v;
    mesh::Vertex before;
    dvec3 to;
    bool stays;
  };
  struct Affected {
    mesh::Index f;
    double volume6;  // m³ × 6, with the head's centre
    dvec3 normal;    // twice the area long
  };
  /// May intersect, by its distance from the head.
  struct Candidate {
    mesh::Index f;
    double within;  // m from the head
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
    int steps = 0, step = 0;  // in all, and begun
  };
  /// In order, but kSelect after kUnfoldAgain. kDone: the whole cut.
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
  /// fn(i) from at_ to `count` - 1 while effort lasts, `cost` each. True: all.
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
  /// By a centre's coordinate (m).
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
  // search (look_) that last visited each
  std::vector<std::uint32_t> vertex_seen_, face_seen_;
  std::vector<std::uint32_t> place_of_;  // in moved_, per vertex of this step
  std::uint32_t edge_look_ = 0;
  // per vertex: last round (edge_look_) with a face around away from the head
  std::vector<std::uint32_t> edge_seen_;
  std::vector<mesh::Index> near_, sorted_, suspects_;
  HeadDistances distances_{kMostTogether};           // for distances at once
  std::array<Candidate, kMostTogether> candidates_;  // face per point, in the selection
  // m, of near_, in slices
  std::vector<float> ball_x_, ball_y_, ball_z_, ball_r_;
  std::vector<std::uint32_t> ball_at_;  // in near_
  int slice_axis_ = 0;                  // of the slices
  float slice_lo_ = 0, slices_per_m_ = 0;
  float widest_ = 0;  // m, in the slices
  // first ball per slice; then the first large one, and the end
  std::array<std::uint32_t, kSlices + 2> slice_start_{};
  // with the ball under test
  std::vector<std::uint32_t> overlapping_;
  // Corners of near_ in the balls' order, only if very many overlap: at a hole's rim the membrane left between a
  // sheet's sides gathers tiny faces.
  mesh::TriangleTable crowd_;
  bool crowded_ = false;                // filled in this round
  std::vector<std::uint32_t> slot_of_;  // in crowd_, if there
  // last round without a crossing
  std::vector<std::uint32_t> tested_in_;
  std::vector<Moved> moved_;
  std::vector<Affected> affected_;
  bool thin_ = false;  // some face away from the head (thin wall, undercut)
  // Of a cut in parts.
  Job job_;
  Placed head_;                            // in this step
  mesh::EditableMesh::NearSearch search_;  // search for the faces near head_
  double margin_ = 0;                      // m from the head
  bool takes_known_ = false;               // from the list number known_
  std::uint64_t known_ = 0;
  Stage stage_ = Stage::kDone;
  Effort left_ = 0;               // effort left in this work()
  std::size_t at_ = 0;            // face or vertex where the stage goes on
  std::size_t looking_away_ = 0;  // faces away from the head, first in suspects_
  bool held_ = false;             // vertices went back in this round
  int rounds_ = 0;                // rounds in this step
  // vertices went back in this round of keep_unfolded()
  bool unfold_held_ = false;
  int unfold_rounds_ = 0;  // rounds of keep_unfolded() in this step
  CutDone done_;
};

/// m³ × 6, with a point.
inline double volume6(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& p) noexcept {
  return glm::dot(a - p, glm::cross(b - p, c - p));
}

}  // namespace typodont::haptics::vertex
