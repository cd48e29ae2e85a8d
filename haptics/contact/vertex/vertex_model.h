// The servo's half of "vertex" (README.md): a head that vertices hold off, springs on the vertices that it would push.
#pragma once

#include <vector>

#include "haptics/contact/cut_log.h"
#include "haptics/contact/vertex/plane_projection.h"
#include "haptics/contact/vertex/vertex_body.h"
#include "haptics/contact_model.h"
#include "haptics/servo.h"

namespace typodont::haptics::vertex {

/// The numbers of contact and force, most as shares of the head's radius.
struct FeelParameters {
  static constexpr double probe = 0.2;  // depth at which the springs are counted: many vertices, none behind the centre
  /// K_s over the coupling's stiffness. The mean way out of a ball that lies `probe` deep in a plane is (1 - probe) /
  /// (2 - probe) of that depth; so a ball is felt as stiff as by the models with a coupling.
  static constexpr double spring = (2 - probe) / (1 - probe);
  static constexpr double step = 0.15;     // the head's way in one look at the vertices around it, …
  static constexpr int looks = 2;          // … how many looks a tick has …
  static constexpr double settled = 0.2;   // … and the share of that way below which no other is needed
  static constexpr double kept = 0.15;     // way for which the vertices found around the head serve
  static constexpr double led_out = 0.05;  // overlap above which the head was found in tissue
  static constexpr double sweep = 0.04;  // of the edge: the least way that is cut at once, so that not every tick cuts
  static constexpr double stride = 0.5;  // of the edge: the longest
  static constexpr double look_ahead = 0.5e-3;  // m that a free head looks around itself
};

/// Servo thread.
class VertexModel final : public ContactModel {
 public:
  /// Throws Error for a tool that fills: vertices only give way.
  VertexModel(const ServoSettings& settings, const Parameters& parameters);

  void adopt(Snapshot& fresh, PerTissue& removed) noexcept override;
  const Snapshot& snapshot() const noexcept override { return snapshot_; }
  double travel() const noexcept override;
  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return !head().is_ball(); }
  void begin_anew() noexcept override { forget(); }
  void release() noexcept override { forget(); }
  bool may_take_up(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& out) noexcept override;
  Tissue tissue_at(const dvec3& p_W) const noexcept override;

 private:
  static constexpr std::size_t kMostSamples = 1 << 16;
  /// A vertex near the head, or one that refining a large face would give.
  struct Sample {
    dvec3 p;        // m, W
    double area;    // m², that it stands for: a third of the triangles around it
    mesh::Index v;  // kNone: not of the mesh
    Tissue tissue;
  };
  /// What the vertices inside a head add up to.
  struct Springs {
    dvec3 force{0}, torque{0};  // N and N·m times m², before division by the area
    double area = 0;            // m², that the vertices stand for …
    double across = 0;          // m², … seen along the pull
    PerTissue tissue{};         // by area × depth
    int count = 0;
  };

  const VertexHead& head() const noexcept { return heads_[tool_]; }
  double edge() const noexcept { return edges_[tool_]; }
  void forget() noexcept;
  bool is_free(const VertexHead& head, double edge, const Pose& X_W) noexcept;
  void gather(const dvec3& p_W, double reach, double edge) noexcept;
  void add(const Sample& sample) noexcept {
    if (samples_.size() < kMostSamples) samples_.push_back(sample);
  }
  dvec3 follow(const dvec3& from, const Pose& X_WT, bool& led_out) noexcept;
  Springs springs_at(const Pose& X, const dvec3& pull) const noexcept;
  void constrain_as_printed(const ContactInput& in, Contact& out) noexcept;
  void give(const ContactInput& in, const Springs& springs, double scale, Contact& out) noexcept;

  const ServoSettings& settings_;
  Parameters parameters_;
  VertexSnapshot snapshot_;
  std::vector<VertexHead> heads_;  // one a tool
  std::vector<double> edges_;      // m, that each of them asks for
  std::uint32_t tool_ = 0;
  Springs springs_;
  dvec3 filtered_{0};  // N, the last force behind the filter
  std::vector<mesh::Index> near_;
  std::vector<Sample> samples_;
  bool found_ = false;  // samples_ are those around found_at_, and the mesh has not changed since
  dvec3 found_at_{0};
  std::vector<StepBound> bounds_;
  RecentCuts<MadeCut> made_;
};

}  // namespace typodont::haptics::vertex
