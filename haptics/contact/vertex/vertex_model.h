// The servo's part of the contact model "vertex". The vertices of the mesh keep the head outside. Each vertex that a
// small virtual motion of the head would push gives a spring. README.md defines the terms.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "haptics/contact/contact_model.h"
#include "haptics/contact/cut_log.h"
#include "haptics/contact/vertex/head_follow.h"
#include "haptics/contact/vertex/vertex_body.h"
#include "haptics/servo.h"

namespace typodont::haptics::vertex {

/// Parameters of contact and force. Most of them are ratios to the head's radius.
struct FeelParameters {
  // Length of the virtual motion divided by the head's radius. Long enough to push many vertices; short enough that no
  // vertex passes the head's centre.
  static constexpr double probe = 0.2;
  static constexpr double allowed_depth =
      0.01;  // allowed overlap of a head, divided by its radius; a ball that cannot cut may not overlap
  // Largest force perpendicular to the pull (direction from head to hand) divided by the force along the pull.
  static constexpr double max_aside = 0.25;
  // N/s, largest change of a bur's force while the hand rests
  static constexpr double ease = 6.5;
  // Shortest distance that the head advances in a cut, in target edge lengths of the mesh. Energy is collected over
  // several ticks until it is enough for this distance.
  static constexpr double sweep = 0.04;
  // Shortest distance that the edge of a hand instrument advances in a cut, in target edge lengths of the mesh. Very
  // short, because little energy is available for the cuts of a dragged edge.
  static constexpr double scrape = 2e-5;
  // Longest distance that the head advances in a cut, in target edge lengths of the mesh.
  static constexpr double stride = 0.5;
  // A dragged edge cuts only a fraction of the touched area, as it advances by less than the height differences between
  // vertices. A running mean measures this fraction. met_weight: weight of a new value; min_met: smallest mean.
  static constexpr double met_weight = 0.1, min_met = 0.01;
  // Distance to the nearest contact point, in head radii, below which the head counts as touching (clearance 0).
  static constexpr double touches = 0.01;
  static constexpr double search_distance =
      0.5e-3;  // m, distance from the head within which clearance() searches tissue
  // Motion of the head divided by its radius, for which a short list of points is valid. Short lists are used while the
  // head cuts, because it then moves little until the next list.
  static constexpr double short_list = 0.05;
  // When the head has made this fraction of the motion for which a list is valid, the model begins the next list.
  static constexpr double begin_next = 0.3;
  // A new list of points is made at once if clearance_in_list() / radius is below this. A translation stops at the
  // clearance 0 until the next list is ready, but a fast rotation can make the clearance negative.
  static constexpr double min_clearance = -0.1;
  // Motion of the head, in head radii, up to which distances are extrapolated, not computed.
  static constexpr double reuse = 0.02;
  // After a cut of n ticks, the next cut waits for `rest` × (1 − a / b) × n ticks. a: distance that the head could
  // advance in the next cut; b = `hurry` × (cut area / radius²) × edge length.
  static constexpr double rest = 3, hurry = 0.08;
  // The next cut waits for at least `min_rest` × the number of ticks of the last cut, so that fewer than half of the
  // ticks cut. Longer waits would reduce the tissue volume that thin heads remove.
  static constexpr double min_rest = 1.05;
  // Largest computing effort of contact and cut together in one tick, in units of 10 ns. A cut that needs more
  // continues in the next tick.
  static constexpr Effort max_effort = 6500;
  // Effort (units of 10 ns) that cuts and lists of points may use in every tick, even if contact needs max_effort.
  static constexpr Effort min_effort = 2000;
  // Largest computing effort for lists of points in one tick, in units of 10 ns. A fast head needs several lists; if
  // they need more effort, the head continues its motion in the next tick.
  static constexpr Effort max_listed = 15000;
};

/// The servo's part of the contact model "vertex".
class VertexModel final : public ContactModel {
 public:
  /// Throws Error for a filling instrument: cuts only remove.
  VertexModel(const ServoSettings& settings, const Parameters& parameters);

  void adopt(Snapshot& fresh, PerTissue& removed) noexcept override;
  const Snapshot& snapshot() const noexcept override { return snapshot_; }
  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return !head().is_ball(); }
  void begin_anew() noexcept override { forget(), began_ = true; }
  void release() noexcept override { forget(); }
  bool is_free(std::uint32_t tool, const Pose& X_W) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& contact, Felt& out) noexcept override;
  Tissue tissue_at(const dvec3& p_W) const noexcept override;

 private:
  static constexpr std::size_t kMaxSamples = 1 << 16;
  static constexpr std::size_t kMaxProposed = 64;  // largest number of points whose distances are computed at once
  /// A contact point near the head: a vertex, or an additional point on a large face.
  struct Sample {
    double area;    // m², area that the point represents, one third of the area of the triangles around the point
    mesh::Index v;  // index of the vertex; kNone: not a vertex
    Tissue tissue;
  };
  /// A list of contact points near the head. `samples` contains the data of each point, in the same order.
  struct PointList {
    mesh::NearPoints points{kMaxSamples};
    std::vector<Sample> samples;
    double within = 0;  // m; the list contains all points within this distance of the head at points.listed_at()
  };
  /// The state of a list while it is being made.
  struct Listing {
    enum class Stage : std::uint8_t { kFaces, kVertices, kAreas, kDone } stage = Stage::kDone;
    const VertexHead* head = nullptr;
    double edge = 0;  // m, target edge length of the mesh
    Pose X;           // pose of the head
    glm::dmat3 R_WT{1};
    double margin = 0;  // m, distance from the head within which points are listed
    mesh::EditableMesh::NearSearch search;
    bool searches = false;     // true: the search for near faces has begun
    std::size_t at = 0;        // index in near_ at which the current stage of listing continues
    std::size_t vertices = 0;  // number of listed points that are vertices of the mesh
  };
  /// Sums over the springs of all vertices that push the head. In constrain_as_printed(), the terms are not multiplied
  /// by area: `force` is in N, `torque` in N·m, `tissue` in m.
  struct Springs {
    dvec3 force{0}, torque{0};  // sums of force (N) and torque (N·m), each multiplied by the vertex's area (m²)
    double area = 0;            // m², area that the vertices in contact represent
    double across = 0;          // m², `area` projected along the pull (head to hand)
    double sum = 0;             // N·m², sum of area × force over the vertices
    double weight = 0;          // m³, sum of area × depth over the vertices
    PerTissue tissue{};         // m³, sum of area × depth for each tissue
    int count = 0;
  };

  const VertexHead& head() const noexcept { return heads_[tool_]; }
  double edge() const noexcept { return edges_[tool_]; }
  bool begin_cut(const ContactInput& in, const Contact& contact) noexcept;
  bool work_on_cut(const ContactInput& in, const Pose& proxy) noexcept;
  bool is_ahead(const dvec3& proxy, const ContactInput& in) const noexcept;
  Effort effort_for_cut() const noexcept;
  KnownFaces known_faces() const noexcept {
    return {near_, list_.points.listed_at(), found_ && !near_changed_ ? list_.within : 0, list_.points.number()};
  }
  // Distance from the head within which contact points are listed (m): for a complete list, and for the short list that
  // is used while the head cuts.
  double complete_list_length() const noexcept;
  double short_list_length() const noexcept;
  void forget() noexcept;
  double moved_since_listing(const Pose& X) const noexcept;
  void list_where_needed(const Pose& X, bool cuts) noexcept;
  void complete_list(const Pose& X, double far) noexcept;
  double clearance_in_list(const Pose& X) const noexcept;
  void list_ahead(const ContactInput& in, const Pose& proxy) noexcept;
  void gather(const VertexHead& head, double edge, const Pose& X, double margin) noexcept;
  void begin_list(const VertexHead& head, double edge, const Pose& X, double margin) noexcept;
  bool list_points(PointList& list, Effort& left) noexcept;
  bool list_near_faces(Effort& left) noexcept;
  void list_vertices(PointList& list, mesh::Index f) noexcept;
  void list_area(PointList& list, mesh::Index f) noexcept;
  void propose(PointList& list, const dvec3& p_W, const Sample& sample) noexcept;
  void add_proposed(PointList& list) noexcept;
  Springs springs_at(const Pose& X, const dvec3& pull) noexcept;
  void constrain_as_printed(const ContactInput& in, Contact& out) noexcept;
  dvec3 eased(const ContactInput& in, const dvec3& force) noexcept;
  void give(const ContactInput& in, const dvec3& force, const dvec3& torque, Contact& out) noexcept;
  void come_free(const ContactInput& in, Contact& out) noexcept;

  const ServoSettings& settings_;
  Parameters parameters_;
  VertexSnapshot snapshot_;
  std::vector<VertexHead> heads_;  // one for each tool
  std::vector<double> edges_;      // m, target edge length for each head
  std::uint32_t tool_ = 0;
  Springs springs_;
  bool eases_ = false;             // true: eased() limits the force, because a bur cuts or its last force still fades
  dvec3 eased_{0};                 // N, force that eased() returned in the last tick
  dquat last_R_{1, 0, 0, 0};       // orientation of the hand in the last tick
  std::vector<mesh::Index> near_;  // faces near the head in the last search for points
  PointList list_;
  PointList next_list_;        // list that is being made, for the mesh after a cut or for a moving head (ahead_)
  bool ahead_ = false;         // true: list_ahead() is making next_list_
  bool near_changed_ = false;  // true: near_ was found for next_list_, not for list_
  Listing listing_;
  // computing effort in this tick for lists that gather() made in one call: of all lists, and of the last list
  Effort listed_ = 0, last_list_ = 0;
  bool began_ = false;     // true in the first tick after begin_anew()
  bool found_ = false;     // true: list_ was made for the current mesh and tool
  bool touching_ = false;  // true: the last constrain() found contact, at touching_at_
  dvec3 touching_at_{0};   // m, position of the proxy at this contact
  HeadDistances distances_, proposed_{kMaxProposed};
  std::array<std::pair<dvec3, Sample>, kMaxProposed> proposals_;
  HeadFollower follower_{distances_};
  // running mean of removed volume / (contact area × advance), for a scraping tool edge; see met_weight
  double met_ = 1;
  // 0..1, fraction of the longest advance of a cut; smaller after cuts in which a vertex could not move
  double stride_ = 1;
  /// A cut that may take several ticks. Meanwhile, the contact uses the points that were listed before the cut.
  struct PartialCut {
    bool open = false;  // true: the cut has begun, and cut() has not returned its result yet
    bool scrapes = false;
    std::uint32_t tool = 0;
    Pose from{}, to{};
    double estimated = 0;  // m³, removed volume that is expected for this cut
    CutDone done{};
    bool finished = false;  // true: the mesh is cut completely
    bool lists = false;     // true: the list of points in the cut mesh was begun
    bool advances = false;  // true: the head moves to `to`; valid if `lists` is true
    int ticks = 0;          // number of ticks that the cut took
    int rest = 0;           // number of ticks since the cut was finished
  } part_;
  RecentCuts<MadeCut> made_;
  RisingCount count_;
};

}  // namespace typodont::haptics::vertex
