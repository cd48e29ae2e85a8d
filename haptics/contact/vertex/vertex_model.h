// The part of the contact model "vertex" that runs on the servo thread. README.md of this folder has an overview and
// defines the terms. The vertices of the tissue's mesh keep the tool's head outside the tissue. To compute the force,
// the model imagines a small motion of the head (virtual motion). Each vertex that this motion would push gives a
// spring.
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
  // Length of the virtual motion of the head for which the springs are computed, as a ratio to the head's radius. It is
  // long enough that the virtual motion pushes many vertices, and short enough that no vertex passes the head's centre.
  static constexpr double probe = 0.2;
  static constexpr double slack =
      0.01;  // allowed overlap of a bur or of a head that is not a ball, as a ratio to its radius
  // Limit of the force across the pull (the direction from the head to the hand), as a ratio to the force along the
  // pull.
  static constexpr double most_aside = 0.25;
  // N/s, largest rate of change of a bur's force while the hand does not move
  static constexpr double ease = 6.5;
  // Shortest distance by which a cut advances the head, as a ratio to the target edge length. Until the energy is
  // enough for this distance, it is collected. Otherwise there would be a cut in every tick.
  static constexpr double sweep = 0.04;
  // Shortest distance by which a cut advances a cutting edge that the hand drags without rotation, as a ratio to the
  // target edge length. It is very short, because a dragged edge stores little energy.
  static constexpr double scrape = 2e-5;
  // longest distance by which a cut advances the head, as a ratio to the target edge length
  static constexpr double stride = 0.5;
  // In one tick, the cutting edge of a hand instrument advances by less than the height differences between
  // neighbouring vertices. So it cuts only a fraction of the area that the vertices in contact represent. The model
  // measures this fraction in each cut and computes a running mean. `met_weight`: weight of the newest measurement in
  // the mean; `least_met`: smallest allowed mean.
  static constexpr double met_weight = 0.1, least_met = 0.01;
  // Ratio to the head's radius. If the distance between the head and the nearest contact point is smaller than this,
  // the head counts as touching (clearance 0).
  static constexpr double touches = 0.01;
  static constexpr double look_ahead = 0.5e-3;  // m, search distance around a head without contact
  // While the head cuts, only the points very near to it are listed (short list), because the head moves little until
  // the next list is made. This is the motion for which a short list is valid, as a ratio to the head's radius.
  static constexpr double short_list = 0.05;
  // A list of points is valid until the head has moved by a certain distance. When the head has moved by this fraction
  // of the distance, the model begins to make the next list.
  static constexpr double begin_next = 0.3;
  // Limit of room_in_list() (motion of the head for which the present list is still valid), as a ratio to the head's
  // radius. A head that waits for its next list stops when this motion is used up (0). A fast rotation can make the
  // value negative; below this limit, a new list is made at once.
  static constexpr double least_room = -0.1;
  // Ratio to the head's radius. Distances of points from the head are extrapolated until the head has moved by more
  // than this since they were computed.
  static constexpr double reuse = 0.02;
  // After a cut that took n ticks, the next cut waits for up to `rest` × n ticks, so that most ticks do not cut. The
  // farther the head could advance with the collected energy, the shorter is the wait. There is no wait if this
  // distance is at least `hurry` × (cut area / radius²) × edge length. A thin head has a small cut area, so it waits
  // less and advances in short cuts. If it advanced far at once, it would slide between the vertices.
  static constexpr double rest = 3, hurry = 0.08;
  // The next cut waits for at least `least_rest` × n ticks, so that fewer than half of the ticks cut. With a longer
  // wait, a thin head would remove less tissue, because the length of a cut is limited.
  static constexpr double least_rest = 1.05;
  // Largest computing effort of the contact and a cut together in one tick, in units of 10 ns. A cut that needs more is
  // divided over several ticks.
  static constexpr Effort most_effort = 6500;
  // Smallest computing effort (unit: 10 ns) that a cut or a list may use in a tick. So the cut still makes progress if
  // the contact has used up most of `most_effort`.
  static constexpr Effort least_effort = 2000;
  // Limit of the computing effort of all lists of contact points in one tick, in units of 10 ns. A fast head needs
  // several lists. If the next list would exceed the limit, the head continues its motion in the next tick.
  static constexpr Effort most_listed = 15000;
};

/// The part of the contact model "vertex" that runs on the servo thread.
class VertexModel final : public ContactModel {
 public:
  /// Throws Error for a filling instrument, because a cut can only remove material.
  VertexModel(const ServoSettings& settings, const Parameters& parameters);

  void adopt(Snapshot& fresh, PerTissue& removed) noexcept override;
  const Snapshot& snapshot() const noexcept override { return snapshot_; }
  double travel() const noexcept override;
  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return !head().is_ball(); }
  void begin_anew() noexcept override { forget(), began_ = true; }
  void release() noexcept override { forget(); }
  bool may_change_tool(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& out) noexcept override;
  Tissue tissue_at(const dvec3& p_W) const noexcept override;

 private:
  static constexpr std::size_t kMostSamples = 1 << 16;
  static constexpr std::size_t kMostProposed = 64;  // largest number of points whose distances are computed at once
  /// A contact point near the head: a vertex, or an additional point on a large face.
  struct Sample {
    double area;    // m², area that the point represents, a third of the area of the triangles around it
    mesh::Index v;  // index of the vertex; kNone: the point is not a vertex
    Tissue tissue;
  };
  /// A list of contact points. `samples` contains the data of each point, in the same order.
  struct PointList {
    mesh::NearPoints points{kMostSamples};
    std::vector<Sample> samples;
    double within = 0;  // m, the list contains all points within this distance of the head at points.listed_at()
  };
  /// The state of a list while it is being made.
  struct Listing {
    enum class Stage : std::uint8_t { kFaces, kVertices, kAreas, kDone } stage = Stage::kDone;
    const VertexHead* head = nullptr;
    double edge = 0;  // m, wanted length of mesh edges on the surfaces that the head cuts
    Pose X;           // pose of the head
    glm::dmat3 R_WT{1};
    double margin = 0;  // m, distance from the head within which points are listed
    mesh::EditableMesh::NearSearch search;
    bool searches = false;     // true if the search for faces near the head has begun
    std::size_t at = 0;        // index in near_ at which the present stage continues
    std::size_t vertices = 0;  // number of listed points that are vertices of the mesh
  };
  /// Sums over the springs of the vertices that push the head. constrain_as_printed() computes sums without the area:
  /// its `force` is in N, its `torque` in N·m and its `tissue` in m.
  struct Springs {
    dvec3 force{0}, torque{0};  // sums of force (N) and torque (N·m), each multiplied by the vertex's area (m²)
    double area = 0;            // m², area that the vertices in contact represent
    double across = 0;          // m², projection of `area` onto a plane perpendicular to the pull (from head to hand)
    double sum = 0;             // N·m², sum of (area × magnitude of the force) over the vertices
    double weight = 0;          // m³, sum of (area × depth) over the vertices in contact
    PerTissue tissue{};         // m³, sum of (area × depth) over the vertices in contact, for each tissue
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
  // The next two functions return the distance (m) from the head within which points are listed: in a complete list,
  // and in the short list that is used while the head cuts.
  double complete_list_length() const noexcept;
  double short_list_length() const noexcept;
  void forget() noexcept;
  bool is_free(const VertexHead& head, double edge, const Pose& X_W) const noexcept;
  double moved_since_listing(const Pose& X) const noexcept;
  void list_where_needed(const Pose& X, bool cuts) noexcept;
  void complete_list(const Pose& X, double far) noexcept;
  double room_in_list(const Pose& X) const noexcept;
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
  std::vector<VertexHead> heads_;  // heads, one for each tool
  std::vector<double> edges_;      // m, for each head: wanted length of mesh edges on the surfaces that it cuts
  std::uint32_t tool_ = 0;
  Springs springs_;
  dvec3 filtered_{0};              // N, force of the last tick after the filter
  bool eases_ = false;             // true: eased() limits the force: a bur cuts, or its last force still fades
  dvec3 eased_{0};                 // N, force that eased() returned in the last tick
  dquat last_R_{1, 0, 0, 0};       // orientation of the hand in the last tick
  std::vector<mesh::Index> near_;  // faces near the head in the last search for points
  PointList list_;
  PointList next_list_;        // list that is being made: for the mesh after a cut, or for a moving head (ahead_)
  bool ahead_ = false;         // true while list_ahead() makes next_list_
  bool near_changed_ = false;  // true if near_ (faces near the head) was found for next_list_ and not for list_
  Listing listing_;
  // computing effort in this tick: listed_: of all lists that were made in one piece; last_list_: of the last such list
  Effort listed_ = 0, last_list_ = 0;
  bool began_ = false;     // true in the first tick after begin_anew()
  bool found_ = false;     // true if list_ was made for the present mesh and tool
  bool touching_ = false;  // true if the last constrain() found contact, at position touching_at_
  dvec3 touching_at_{0};   // m, position of the proxy at which the last constrain() found contact
  HeadDistances distances_, proposed_{kMostProposed};
  std::array<std::pair<dvec3, Sample>, kMostProposed> proposals_;
  HeadFollower follower_{distances_};
  // for an edge that the hand drags: running mean of (removed volume) / (contact area × advance); see met_weight
  double met_ = 1;
  /// A cut that may take several ticks. Until the cut is finished, the contact is computed from the points that were
  /// listed before the cut began.
  struct PartialCut {
    bool open = false;  // true from the start of the cut until cut() has returned its result
    bool scrapes = false;
    std::uint32_t tool = 0;
    Pose from{}, to{};
    double estimated = 0;  // m³, removed volume that was expected when the cut began
    CutDone done{};
    bool finished = false;  // true if the cut of the mesh is complete
    bool lists = false;     // true if the list of points after the cut has been begun
    bool advances = false;  // true if the head will move to the pose `to`; valid only if `lists` is true
    int ticks = 0;          // number of ticks that the cut took
    int rest = 0;           // number of ticks since the cut was finished
  } part_;
  RecentCuts<MadeCut> made_;
  RisingCount count_;
};

}  // namespace typodont::haptics::vertex
