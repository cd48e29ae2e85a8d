// Gingiva that yields, pushes back, recovers, and is cut and bleeds (haptics/soft/README.md).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/clock.h"
#include "engine/base/pose.h"
#include "engine/base/voxels.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Parameters of soft tissue in SI units. Sources: haptics/soft/README.md.
struct SoftLaw {
  double elastic_modulus = 1e6;  // Pa, Young's modulus
  // Largest thickness of the layer, m. Where the tissue is thinner, its real thickness is used.
  double thickness = 2e-3;
  double return_time = 0.2;         // s, time constant of recovery after release
  double friction = 0.1;            // Coulomb coefficient, for a tool that does not rotate
  double specific_energy = 0.3e9;   // J/m³, for cutting with a bur
  double spacing = 0.35e-3;         // m, distance between the simulated points
  double bleeding_depth = 0.25e-3;  // m, depth above which a cut bleeds
  double blood_radius = 2.5e-3;     // m, final radius of the blood stain around a wound
  double blood_time = 8;            // s, time constant with which the blood stain grows
};

/// A point where a cut of the soft tissue bleeds.
struct SoftWound {
  Nanos t = 0;   // time at which the bleeding began, ns
  dvec3 p_W{0};  // m, position of the wound
};
/// Radius of the blood stain at `age` (s), m.
double blood_radius(const SoftLaw& law, double age) noexcept;

/// Displacement of a point, for the renderer.
struct SoftMove {
  std::uint32_t point = 0;  // index in SoftSurface::points()
  // Depth below the rest position, elastic plus cut, m.
  float inward = 0;
};

/// Surface of soft tissue at rest: points with normal, area, thickness, links to neighbours. Immutable; any thread.
class SoftSurface {
 public:
  struct Point {
    dvec3 p_W{0};          // m, position at rest
    dvec3 n_W{0, 0, 1};    // unit normal, pointing out of the tissue
    double area = 0;       // m², surface area that the point represents
    double thickness = 0;  // m, thickness of the soft layer below the point
  };
  struct Link {
    std::uint32_t point = 0;  // index of the neighbouring point
    double tension = 0;       // N/m, force per difference of the two points' displacements
  };
  /// `distance`: signed distance from a position in frame W to the tissue's surface, m, negative inside. Where `hidden`
  /// is true, no points are created, and the layer ends. `lo`, `hi`: sampled box. Throws std::invalid_argument above 16
  /// million cells.
  SoftSurface(
      const SoftLaw& law, const dvec3& lo, const dvec3& hi, const std::function<double(const dvec3&)>& distance,
      const std::function<bool(const dvec3&)>& hidden = [](const dvec3&) { return false; });

  const SoftLaw& law() const { return law_; }
  std::span<const Point> points() const { return points_; }
  std::span<const Link> links(std::size_t point) const {
    return std::span(links_).subspan(first_link_[point], first_link_[point + 1] - first_link_[point]);
  }
  /// Returns a lower bound of the distance to the nearest point, m, at least 0.
  double clearance(const dvec3& p_W) const noexcept;
  /// Calls `visit(point)` for all points in the cells that overlap the box `lo` to `hi`.
  template <class Visit>
  void each_near(const dvec3& lo, const dvec3& hi, Visit&& visit) const noexcept {
    for_each_voxel_between(cell_of(lo), cell_of(hi), [&](const glm::ivec3& c) {
      const std::size_t cell = cell_index(c);
      for (std::uint32_t i = cell_first_[cell]; i < cell_first_[cell + 1]; ++i) visit(cell_points_[i]);
    });
  }

 private:
  void build_cells();
  glm::ivec3 cell_of(const dvec3& p_W) const noexcept;
  std::size_t cell_index(const glm::ivec3& cell) const noexcept { return voxel_index(cell, cells_); }

  SoftLaw law_;
  std::vector<Point> points_;
  std::vector<std::uint32_t> first_link_;
  std::vector<Link> links_;
  dvec3 lo_{0};
  glm::ivec3 cells_{0};
  std::vector<std::uint32_t> cell_first_, cell_points_;
  // For each cell: lower bound of the distance from any position in it to the nearest point of the soft tissue, m.
  std::vector<float> cell_clearance_;
};

/// The simulation of soft tissue. Servo thread only; never allocates. Deterministic.
class SoftTissue {
 public:
  /// Largest number of points that move at once; further points stay at rest.
  static constexpr std::size_t kMaxActive = 512;
  static constexpr std::size_t kMaxWounds = 16;

  /// `tools` must outlive the object. `coupling`: stiffness of the spring between hand and tool, N/m.
  SoftTissue(std::shared_ptr<const SoftSurface> surface, std::span<const Tool> tools, double coupling);

  struct Input {
    Nanos t = 0;
    double dt = 1e-3;        // s, duration of this tick
    Pose X_WG;               // pose that the tool would have without soft tissue
    std::uint32_t tool = 0;  // index of the tool
    double cutting = 0;      // m/s, speed of the bur's circumference × cutting coefficient; 0: the tool does not cut
  };
  struct Output {
    dvec3 force{0};     // N, force of the soft tissue on the tool
    dvec3 yielded{0};   // m, displacement of the tool from X_WG by soft tissue
    double stored = 0;  // J, energy in the spring between hand and tool
    bool touching = false;
  };
  /// Returns true if a tick would change nothing: no point moves, and the tool is too far away.
  bool at_rest(const Pose& X_WG, std::uint32_t tool) noexcept;
  Output tick(const Input& in) noexcept;
  /// Call when the hand is lost: the tool touches nothing until the next tick().
  void release() noexcept;
  /// Returns true if the last tick found contact.
  bool touching() const noexcept { return touching_; }

  const SoftSurface& surface() const noexcept { return *surface_; }
  /// Elastic displacement plus depth of the cut, m.
  double inward(std::uint32_t point) const noexcept;
  /// Depth that a bur has cut at the point, m.
  double cut_depth(std::uint32_t point) const noexcept { return cut_[point]; }
  std::span<const SoftWound> wounds() const noexcept { return {wounds_.data(), wound_count_}; }
  std::size_t active() const noexcept { return active_.size(); }
  /// Calls `send(SoftMove)` for visibly moved points, until it returns false.
  template <class Send>
  void send_moves(Send&& send) noexcept {
    constexpr float kVisible = 1e-6f;  // m, smallest displacement that is visible
    for (std::size_t i = 0; i < to_send_.size();) {
      const std::uint32_t point = to_send_[i];
      const auto now = static_cast<float>(inward(point));
      const bool at_rest = slot_[point] < 0;
      if (now != sent_[point] && (at_rest || std::abs(now - sent_[point]) > kVisible)) {
        if (!send(SoftMove{point, now})) return;
        sent_[point] = now;
      }
      if (at_rest) {
        waits_[point] = 0;
        to_send_[i] = to_send_.back();
        to_send_.pop_back();
      } else {
        ++i;
      }
    }
  }

 private:
  /// A point that is not at rest.
  struct Active {
    std::uint32_t point = 0;
    // Elastic displacement of the point now and at the start of the tick, m.
    double v = 0, before = 0;
    double stiffness = 0;  // N/m, stiffness of the layer below the point
    double springs = 0;    // N/m, stiffness of the layer plus that of the links
    // Largest allowed sum of the point's elastic displacement and the depth of its cut, m.
    double limit = 0;
    double yield = 0;  // m/N, displacement per contact force within one tick
    bool contact = false;
    double exit = 0;  // m, largest depth of the head below the point's rest position
    // Weight of the contact: 1 if the head presses from above, 0 if its side passes the point.
    double weight = 0;
    dvec3 slope{0};  // gradient of the depth `exit` with respect to the tool's position
    // m, part of an initial overlap that causes no force; it decreases to zero
    double ignored = 0;
    double force = 0;  // N, force of the tool on the point
    double stop = 0;   // N, further force of the tool on a point at its largest depth (`limit`)
  };
  /// A tool as a distance function, with enclosing balls for fast tests.
  struct Shape {
    HeadField head, shank;
    double shank_z = 0;  // m, z of the shank's centre on the tool's axis
    // Enlargement of the head, m, so that a thin tip does not pass between the points of the surface.
    double blunt = 0;
    bool has_shank = false;
    struct Ball {
      double z = 0, r = 0;  // m, ball's centre on the axis, and its radius
    };
    std::vector<Ball> balls;
    // Ends of the tool on the axis (z), largest radius, and largest distance from the origin of T, m.
    double low = 0, high = 0, radius = 0, reach = 0;
    double distance(const dvec3& p_T) const noexcept;
    dvec3 gradient(const dvec3& p_T) const noexcept;
  };

  bool activate(std::uint32_t point) noexcept;
  void find_contacts(const Input& in, const Pose& X_WT, const Shape& shape, double moved) noexcept;
  void touch(Active& a, const Pose& X_WT, const Shape& shape, double allowed, double fade) noexcept;
  void relax() noexcept;
  void place_tool(double most) noexcept;
  void cut(const Input& in) noexcept;
  void bleed(std::uint32_t point, Nanos t) noexcept;
  void spread_and_sleep() noexcept;

  std::shared_ptr<const SoftSurface> surface_;
  std::vector<Shape> shapes_;
  double coupling_;  // N/m, stiffness between hand and tool
  std::vector<Active> active_;
  std::vector<std::int32_t> slot_;  // for each point: index in active_; -1: at rest
  // For each point: depth of the cut, and displacement last sent to the renderer, m.
  std::vector<float> cut_, sent_;
  std::vector<std::uint8_t> waits_;     // for each point: 1 if it is in to_send_
  std::vector<std::uint32_t> to_send_;  // points that may have moved since they were last sent
  std::array<SoftWound, kMaxWounds> wounds_{};
  std::size_t wound_count_ = 0;
  // Displacement of the tool in this and in the previous tick, m.
  dvec3 u_{0}, u_before_{0};
  bool touching_ = false;
  bool placed_ = false;  // true if last_ contains the pose of the last tick
  Pose last_;
  std::uint32_t tool_ = 0;
  Pose seen_;        // pose of the tool for which gap_ was computed
  double gap_ = -1;  // m that the tool may move from seen_ before it can touch soft tissue; negative: unknown
};

}  // namespace typodont::haptics
