#include "engine/app/hands/expert.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine/app/hands/expert_terrain.h"
#include "engine/app/hands/stroke_planner.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/in_parallel.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/session/task.h"
#include "haptics/fill.h"
#include "haptics/scripted_hand.h"

namespace typodont {

namespace {

/// Factors for the force of cuts. ExpertHand moves ahead of the tool so far that the coupling gives this force.
struct CutForce {
  // Force at a coarse diamond bur's side / mean force of the task: 1.71 N on axial walls of a crown / 1 N.
  static constexpr double coarse = 1.71;
  // Upper limit of a cut's force, as a fraction of the task's largest force.
  static constexpr double below_max = 0.9;
};

/// Parameters for joining strokes to one sequence of steps.
struct Joining {
  // Cosine of the angle between two strokes: full speed above straight_on, slowest speed below `turn`.
  static constexpr double straight_on = 0.9, turn = 0.3;
  // Speed at the joint of two strokes, m/s. aside_pace: for a cosine between `turn` and straight_on; turn_pace: for a
  // cosine below `turn`.
  static constexpr double aside_pace = 8e-3, turn_pace = 3e-3;
  static constexpr double coarse_haste = 2.5;  // factor on aside_pace and turn_pace for a coarse tool
  // m; if the gap between two strokes is smaller, the tool goes directly from the first stroke to the second.
  static constexpr double no_gap = 1e-6;
  // Largest length of a run (strokes without a stop between them) of a hand instrument, m.
  static constexpr double longest_run = 3e-3;
  // m; if the gap between two strokes is smaller, the tool is not lifted between them.
  static constexpr double joined = 0.6e-3;
  // Height of the tool above the highest obstacle on its way between two strokes, m.
  static constexpr double hop = 0.5e-3;
  static constexpr double shank_radius = 0.8e-3;  // m, radius of a bur's shank
  // Tissue beside the tool's path counts as an obstacle up to this distance from the tool, m.
  static constexpr double beside = 0.3e-3;
  static constexpr double above = 1.0e-3;  // m, height of free motion above the highest tissue
  // Time for which the drill runs before a cut, in time constants of its speed: it then has 91 % of its full speed.
  static constexpr double run_up = 2.4;
};

/// Voxel size in a typical CT of a tooth, m. Larger voxels mean a larger object
/// than a tooth, so all lengths of the motion increase in proportion.
constexpr double kVoxelOfATooth = 0.15e-3;

ExpertGrip grip_of(const Scene& scene, double voxel, const PlanMargins& margins) {
  ExpertGrip grip;
  grip.margins = margins;
  grip.size = std::max(1.0, voxel / kVoxelOfATooth);
  for (const session::ScoreRule& rule : session::rules_of_scene(Json::parse(scene.text, scene.file.string()), {})) {
    if (rule.name == "force_mean_N" && rule.target > 0) grip.force = rule.target;
    if (rule.name == "force_max_N" && rule.target > 0) grip.max_force = CutForce::below_max * rule.target;
  }
  // The default limit is for teeth. If the task needs a larger mean force, there is no limit.
  if (grip.max_force < grip.force) grip.max_force = std::numeric_limits<double>::infinity();
  if (scene.servo.stiffness > 0) grip.lead = grip.force / scene.servo.stiffness;
  return grip;
}

/// Parameters for the choice and order of the cutting tools.
struct ToolChoice {
  // Distance between two passes, as a fraction of the tool's diameter; smallest and largest such distance, m.
  static constexpr double pass = 0.22, min_pass = 0.12e-3, max_pass = 0.5e-3;
  // Distance between passes of a coarse tool, in diameters, and its upper limit, m (ridges: 0.04 mm high).
  static constexpr double coarse_pass = 0.26, max_coarse_pass = 0.6e-3;
  // Allowed overlap of a hand instrument with tissue that must stay, m. A negative value keeps a distance: if the
  // instrument touched the enamel, the enamel would carry the force, and the filling beside it would hardly be cut.
  static constexpr double edge_allowance = -0.02e-3;
  static constexpr double allowance = 0.005e-3;  // m, allowed overlap of a bur with tissue to keep
  // Thinnest cut of a bur, m. The score tolerates 0.02 mm of remaining tissue, so thinner cuts are not needed.
  static constexpr double min_cut = 0.015e-3;
  // The error is the volume that differs from the target shape. A tool is good enough if it reduces the error by at
  // least (1 - tolerated_loss) of the best tool's reduction. The widest good tool is used, because it is the fastest.
  static constexpr double tolerated_loss = 0.12;
  static constexpr double same_width = 0.01e-3;  // m; tools whose widths differ by less count as equally wide
  // If the best tool leaves an error below this factor × the chosen tool's error, a later tool makes the final surface.
  static constexpr double hardly_less = 0.6;
  // Another tool is used only if the error after it is below needed_reduction · current error, and if it reduces the
  // error by at least min_gain · initial error.
  static constexpr double needed_reduction = 0.9, min_gain = 0.012;
  static constexpr std::size_t max_tools = 3, max_tried = 5;
};

/// Parameters of filling. The material is added in portions: balls around the surface point nearest to the tool's end.
struct Filling {
  // Height of the instrument above the tissue on its way between two portions of filling, m.
  static constexpr double hop_over = 0.3e-3;
  static constexpr double grid = 0.15e-3;  // m, distance between the instrument positions that are evaluated
  static constexpr int head_points = 120;
  static constexpr double down = 0.04e-3;  // m, step in which the instrument is lowered to tissue
  // Largest step of the lowering instrument, as a fraction of the remaining distance to the tissue.
  static constexpr double trusted = 0.7;
  static constexpr double free = 0.03;  // voxels, distance that remains between instrument and tissue
  // Largest height and radius of a portion of filling, as fractions of the tool's `fill_reach`.
  static constexpr double portion_height = 0.6, portion_radius = 0.98;
  // Largest height of a portion above the cavity's floor, in radii of
  // the instrument. Higher up, a wall would be nearer than the floor.
  static constexpr double below_wall = 0.8;
  // If a wall is nearer than near_wall (m), the instrument moves towards it in steps of `nudge` (m).
  static constexpr double near_wall = 0.2e-3, nudge = 0.02e-3;
  // Step in which the instrument rises out of the filling, m. At each step, it fills the hole that it leaves.
  static constexpr double rise = 0.3e-3;
  // Distance between the ball of filling and the head, voxels.
  static constexpr double head_free = 0.5;
  // If the distance field's gradient is shorter than this, the point is midway between two surfaces. Near one: 1.
  static constexpr double one_surface = 0.5;
  // Largest height of filling above the final contour, m: in the first and in the second pass.
  static constexpr double proud = 0.12e-3, overfill = 0.4e-3;
  // Cost of unwanted filling, relative to the gain of wanted filling. carved_again, overfilled: filling above the
  // cavity in the first and in the second pass, which is carved away later. flash: filling on the enamel beside the
  // cavity, where a hand instrument hardly removes it.
  static constexpr double carved_again = 0.1, overfilled = 0.03, flash = 3;
  // Depth below the contour, voxels. A position is over the cavity if the point at this depth was empty before the
  // task.
  static constexpr double rim = 0;
  // Height above the lowest voxel that lacks filling, m. Only filling up to this height counts as gain.
  static constexpr double layer = 0.6e-3;
  // A voxel counts as filled if it is this deep inside the ball of filling, voxels.
  static constexpr double whole_voxel = 0.9;
  // Volume of the smallest portion, m³. It can be added in one tick of the servo.
  static constexpr double min_volume = 0.004e-9;
  static constexpr int at_once = 1;  // number of portions of filling that are planned together
  // A portion of filling is abandoned after `longer` times its planned duration plus `min_time` (s).
  static constexpr double longer = 1.2, min_time = 0.1;
};

/// Parameters that decide when cutting and filling end.
struct Rounds {
  // After filling, another round of cutting always follows. After cutting, another round follows only if the last
  // round left less than this fraction of the error.
  static constexpr double still_left = 0.5;
  // The same for a deposit on the tooth, because each round takes only a part of the film that the last one left.
  static constexpr double still_left_of_deposit = 0.9;
  static constexpr int max_cuts = 4;  // largest number of rounds of cutting
  // Thickness of excess filling that the first carving leaves, m.
  static constexpr double clearly_too_high = 0.1e-3;
  // A layer of filling that adds less volume than this counts as useless, m³.
  static constexpr double min_layer = 0.01e-9;
  // Number of useless layers in a row before the next instrument is used.
  static constexpr int max_vain = 3;
};

/// Volume of tissue that differs from the ideal shape, m³. `voxel`: edge of a voxel, m.
double remaining_difference(const session::DenseField& tissue, const session::DenseField& ideal, double voxel) {
  double sum = 0;
  for (std::size_t i = 0; i < tissue.distance.size(); ++i) {
    sum += std::abs(session::fraction_inside(static_cast<double>(tissue.distance[i])) -
                    session::fraction_inside(static_cast<double>(ideal.distance[i])));
  }
  return sum * voxel * voxel * voxel;
}

/// Volume in which tissue is missing, m³.
double missing_in(const session::DenseField& tissue, const session::DenseField& ideal, double voxel) {
  double sum = 0;
  for (std::size_t i = 0; i < tissue.distance.size(); ++i) {
    sum += std::max(0.0, session::fraction_inside(static_cast<double>(ideal.distance[i])) -
                             session::fraction_inside(static_cast<double>(tissue.distance[i])));
  }
  return sum * voxel * voxel * voxel;
}

/// Mean diameter of the head over its length, m.
double mean_width(const haptics::Tool& tool) {
  constexpr int kPlaces = 16;
  double sum = 0;
  for (int k = 0; k < kPlaces; ++k) sum += 2 * tool.profile(tool.half() * (2 * (k + 0.5) / kPlaces - 1));
  return sum / kPlaces;
}

class Plan {
 public:
  /// `compared`: judge.preparation(now). `filled`: positions where earlier plans added portions; this plan appends its
  /// own.
  Plan(const Scene& scene, const ExpertGrip& grip, const haptics::TissueVolume& now,
       const session::Preparation& compared, const TaskEvaluator& judge, const SurroundingsShape* around, double whole,
       std::vector<FilledSpot>& filled)
      : grip_(grip),
        compared_(compared),
        whole_(whole),
        filled_(filled),
        around_(around),
        tools_(haptics::tool_set(scene.servo)),
        run_up_time_(scene.servo.spindle.run_up_time),
        judge_(judge),
        state_(now.clone()),
        axis_(glm::normalize(scene.task->axis_W)) {
    glm::ivec3 lo, hi;
    now.bounds(lo, hi);
    for (int corner = 0; corner < 8; ++corner) {
      const dvec3 p =
          now.frame().to_world(dvec3(corner & 1 ? hi.x : lo.x, corner & 2 ? hi.y : lo.y, corner & 4 ? hi.z : lo.z));
      top_ = std::max(top_, glm::dot(p, axis_));
    }
    for (const haptics::Tool& tool : tools_) above_ = std::max(above_, top_ + tool.reach() + Joining::above);
  }

  /// Plans cuts with one tool after the other, until no tool reduces the error enough. Tissue thinner than
  /// `min_thickness` (m) is not cut.
  void cut(bool by_hand, double min_thickness = 0) {
    std::vector<bool> used(tools_.size());
    for (std::size_t round = 0; round < ToolChoice::max_tools; ++round) {
      std::vector<Candidate> candidates;
      for (std::size_t i = 0; i < tools_.size() && candidates.size() < ToolChoice::max_tried; ++i)
        if (!used[i] && tools_[i].cuts && tools_[i].turns() != by_hand) candidates.push_back({i, 0, {}});
      if (candidates.empty()) return;
      session::Preparation now = preparation();
      const double voxel = now.frame.voxel;
      const bool tooth_stops = by_hand && has_deposit() && grip_.margins.into_tooth > 0;
      // A planned cut into tissue that stops the instrument is no error.
      const auto error = [&](const session::DenseField& tissue, const session::DenseField& ideal) {
        return remaining_difference(tissue, ideal, voxel) - (tooth_stops ? missing_in(tissue, ideal, voxel) : 0);
      };
      // The largest error after cuts that are worth their time.
      const auto worthwhile = [&](double before) {
        return std::min(ToolChoice::needed_reduction * before, before - ToolChoice::min_gain * whole_);
      };
      // Cuts do not reduce what is missing.
      if (worthwhile(error(now.after, now.ideal)) <= (tooth_stops ? 0 : missing_in(now.after, now.ideal, voxel)))
        return;
      // The next strokes start from tissue after the earlier strokes. Filling leaves distances that are too large far
      // from it.
      now.before = fillers() > 0 ? session::redistanced(now.after) : now.after;
      now.ideal = true_distances(std::move(now.ideal));
      const double before = error(now.before, ideal_), most = worthwhile(before);
      in_parallel(
          candidates.size(),
          [&](std::size_t k) {
            Candidate& candidate = candidates[k];
            const haptics::Tool& tool = tools_[candidate.tool];
            StrokePlan planned = plan(now, tool, by_hand, /*finish=*/true, min_thickness);
            candidate.left = error(planned.left, ideal_);
            candidate.strokes = std::move(planned.strokes);
          },
          {}, /*block=*/1);
      double least = most;
      for (const Candidate& candidate : candidates) least = std::min(least, candidate.left);
      Candidate* best = nullptr;
      for (Candidate& c : candidates) {
        if (c.left >= most || c.left > least + ToolChoice::tolerated_loss * (before - least)) continue;
        const double wider = best ? mean_width(tools_[c.tool]) - mean_width(tools_[best->tool]) : 1;
        if (wider > ToolChoice::same_width || (wider > -ToolChoice::same_width && c.left < best->left)) best = &c;
      }
      if (!best) return;
      used[best->tool] = true;
      const haptics::Tool& tool = tools_[best->tool];
      const bool other_finishes = !tooth_stops && least < ToolChoice::hardly_less * best->left;
      const std::vector<Stroke> strokes =
          other_finishes ? plan(now, tool, by_hand, /*finish=*/false, min_thickness).strokes : std::move(best->strokes);
      log::info("{}: {} strokes, from {:.2f} to {:.2f} mm³ off", tool.name, strokes.size(), before * 1e9,
                best->left * 1e9);
      if (goes_straight_in(strokes)) go_up_by_sizes(best->tool, strokes.front());
      const Terrain terrain(state_, around_, axis_);
      carve_strokes(state_, tool, strokes);
      take(static_cast<std::uint32_t>(best->tool), !by_hand);
      follow(strokes, by_hand, terrain);
    }
  }

  /// True if the task is to scrape a deposit off the tooth's own surface.
  bool has_deposit() const { return compared_.contour && fillers() == 0; }
  /// Number of filling instruments in the tool set.
  std::size_t fillers() const {
    return static_cast<std::size_t>(
        std::count_if(tools_.begin(), tools_.end(), [](const haptics::Tool& t) { return t.fill != Tissue::kAir; }));
  }
  /// Plans filling. `coarser`: index of the instrument, sorted by reach, 0 is the finest. `over`: second pass, which
  /// may rise higher and whose excess costs less. Plans nothing if no portion is a gain.
  void fill(std::size_t coarser, bool over) {
    over_ = over;
    std::vector<std::uint32_t> by_reach;
    for (std::uint32_t i = 0; i < tools_.size(); ++i) {
      if (tools_[i].fill != Tissue::kAir) by_reach.push_back(i);
    }
    std::stable_sort(by_reach.begin(), by_reach.end(),
                     [&](auto a, auto b) { return tools_[a].fill_reach < tools_[b].fill_reach; });
    fill_with(by_reach[coarser]);
  }

  struct Candidate {
    std::size_t tool = 0;
    double left = 0;  // m³, difference from the ideal shape after the planned cuts
    std::vector<Stroke> strokes;
  };
  /// The planned tissue, compared with the ideal shape. As long as the plan is empty, that is the tissue at its start.
  session::Preparation preparation() const { return idle() ? compared_ : judge_.preparation(state_); }
  /// The field with true distances; that of the last call if the field is the same.
  const session::DenseField& true_distances(session::DenseField field) {
    if (field.size == ideal_.size && field.distance == ideal_.distance) return true_ideal_;
    true_ideal_ = session::redistanced(field);
    ideal_ = std::move(field);
    return true_ideal_;
  }
  StrokePlan plan(const session::Preparation& now, const haptics::Tool& tool, bool by_hand, bool finish,
                  double min_thickness) const {
    const bool coarse = tool.coarse();
    StrokeOptions options;
    options.step = std::clamp((coarse ? ToolChoice::coarse_pass : ToolChoice::pass) * tool.diameter,
                              grip_.size * ToolChoice::min_pass,
                              grip_.size * (coarse ? ToolChoice::max_coarse_pass : ToolChoice::max_pass));
    options.into = grip_.size * (by_hand ? ToolChoice::edge_allowance + (has_deposit() ? grip_.margins.into_tooth : 0)
                                         : ToolChoice::allowance);
    options.around = around_;
    options.clearance = grip_.margins.clearance;
    options.size = grip_.size;
    options.least = by_hand ? min_thickness : std::max(min_thickness, grip_.size * ToolChoice::min_cut);
    options.finish = finish;
    return plan_strokes(now, tool, options);
  }
  /// Converts `strokes` to steps, and appends these to the plan.
  void follow(const std::vector<Stroke>& strokes, bool by_hand, const Terrain& terrain) {
    force_ = std::min(grip_.max_force, grip_.force * (tools_[tool_].coarse() ? CutForce::coarse : 1));
    double run = 0;  // m, length of the current run (strokes without a stop between them)
    for (std::size_t i = 0; i < strokes.size(); ++i) {
      const Stroke& s = strokes[i];
      const double gap = i == 0 ? 1 : glm::length(s.from.p - legs_.back().to.p);
      if (gap > Joining::joined) go_over(s.from, terrain, /*lifts=*/i > 0);
      if (gap > Joining::no_gap) add(by_hand ? ExpertLeg::Kind::kMove : ExpertLeg::Kind::kCut, s.from), run = 0;
      if (s.in_air) {
        add(ExpertLeg::Kind::kMove, s.to);
        run = 0;
        continue;
      }
      add(by_hand ? ExpertLeg::Kind::kScrape : ExpertLeg::Kind::kCut, s.to);
      run += glm::length(s.to.p - s.from.p);
      legs_.back().rough = legs_.back().coarse && s.bulk;
      if (!s.goes_on || i + 1 == strokes.size() || (by_hand && run > Joining::longest_run)) {
        run = 0;
        if (legs_.back().coarse) legs_.back().end_pace = Joining::turn_pace;
      } else {
        legs_.back().end_pace = pace_over(s, strokes[i + 1]) * (legs_.back().coarse ? Joining::coarse_haste : 1);
      }
    }
    lift();
  }
  /// Speed at the joint of two strokes, m/s.
  static double pace_over(const Stroke& s, const Stroke& next) {
    const dvec3 a = s.to.p - s.from.p, b = next.to.p - next.from.p;
    const double length = glm::length(a) * glm::length(b), cosine = length > 0 ? glm::dot(a, b) / length : 1;
    return cosine > Joining::straight_on ? kExpertCutPace
           : cosine > Joining::turn      ? Joining::aside_pace
                                         : Joining::turn_pace;
  }
  bool goes_straight_in(const std::vector<Stroke>& strokes) const {
    // A stroke counts as parallel to the axis if the cosine of the angle between stroke and axis exceeds this.
    constexpr double kStraight = 1 - 1e-9;
    return strokes.size() == 1 && glm::dot(glm::normalize(strokes[0].from.p - strokes[0].to.p), axis_) > kStraight;
  }
  /// Widens a hole as with a set of reamers: repeats the stroke `in` with every narrower tool of the same shape,
  /// narrowest first, all to the same depth. The tool `last` itself is not included.
  void go_up_by_sizes(std::size_t last, const Stroke& in) {
    std::vector<std::uint32_t> sizes;
    for (std::uint32_t i = 0; i < tools_.size(); ++i) {
      const bool narrower = tools_[i].diameter < tools_[last].diameter - ToolChoice::same_width;
      if (narrower && tools_[i].shape == tools_[last].shape && tools_[i].turns()) sizes.push_back(i);
    }
    std::sort(sizes.begin(), sizes.end(), [&](auto a, auto b) { return tools_[a].diameter < tools_[b].diameter; });
    for (const std::uint32_t i : sizes) {
      Stroke stroke = in;
      stroke.to.p += (tools_[i].half() - tools_[last].half()) * axis_;
      const Terrain terrain(state_, around_, axis_);
      carve_strokes(state_, tools_[i], {stroke});
      take(i, /*drill=*/true);
      follow({stroke}, /*by_hand=*/false, terrain);
    }
  }
  bool idle() const { return legs_.empty(); }
  std::vector<ExpertLeg> take_legs() { return std::move(legs_); }
  haptics::TissueVolume take_state() { return std::move(state_); }

 private:
  void add(ExpertLeg::Kind kind, const Pose& to, double seconds = 0, double volume = 0) {
    legs_.push_back({kind, to, pedal_, tool_, seconds, volume, /*end_pace=*/0, force_, tools_[tool_].turns(),
                     tools_[tool_].coarse()});
  }
  Pose over(Pose pose) const {
    pose.p += (above_ - glm::dot(pose.p, axis_)) * axis_;
    return pose;
  }
  void lift() {
    if (!legs_.empty()) add(ExpertLeg::Kind::kMove, over(legs_.back().to));
  }
  /// Moves to a point high above `to`, over all obstacles. `lifts`: first straight up.
  void go_over(const Pose& to, const Terrain& terrain, bool lifts) {
    const haptics::Tool& tool = tools_[tool_];
    const dvec3 from = legs_.back().to.p;
    const double beside = std::max(tool.radius(), Joining::shank_radius) + Joining::beside;
    double height = terrain.highest(from, to.p, beside) + tool.half() + Joining::hop;
    height = std::max({height, glm::dot(to.p, axis_), lifts ? glm::dot(from, axis_) : -1e9});
    const auto raised = [&](Pose pose) {
      pose.p += (height - glm::dot(pose.p, axis_)) * axis_;
      return pose;
    };
    if (lifts) add(ExpertLeg::Kind::kMove, raised(legs_.back().to));
    add(ExpertLeg::Kind::kMove, raised(to));
  }
  /// Moves up to `height`, sideways, and down to `to`, so that the tool does not touch the new portion of filling.
  void hop(const Pose& to, double height) {
    Pose up = legs_.back().to, across = to;
    up.p += (height - glm::dot(up.p, axis_)) * axis_;
    across.p += (height - glm::dot(to.p, axis_)) * axis_;
    add(ExpertLeg::Kind::kMove, up);
    add(ExpertLeg::Kind::kMove, across);
    add(ExpertLeg::Kind::kMove, to);
  }
  void take(std::uint32_t tool, bool drill) {
    lift();
    pedal_ = 0;
    tool_ = tool;
    const Pose here = legs_.empty() ? over({axis_ * top_, toward(axis_)}) : legs_.back().to;
    add(ExpertLeg::Kind::kTake, here);
    pedal_ = drill ? 1 : 0;
    if (drill) add(ExpertLeg::Kind::kWait, here, Joining::run_up * run_up_time_);
  }

  /// A filling instrument, its shank parallel to the preparation's axis.
  struct Instrument {
    const haptics::Tool& tool;
    dquat R_WT;
    dvec3 u, v, w;             // the instrument's axes in frame W
    double half;               // m, from the head's centre to its free end
    std::vector<dvec3> head;   // m, points on the head relative to its centre, in the axes of W
    haptics::HeadField field;  // m, distance field of the head
    Instrument(const haptics::Tool& t, const dvec3& axis)
        : tool(t),
          R_WT(toward(axis)),
          u(R_WT * dvec3(1, 0, 0)),
          v(R_WT * dvec3(0, 1, 0)),
          w(R_WT * dvec3(0, 0, 1)),
          half(t.half()),
          field(t, 1) {
      for (const haptics::HeadSample& sample : haptics::sample_head(t, Filling::head_points))
        head.push_back(R_WT * sample.p_TQ);
    }
    dvec3 end(const Pose& X_WT) const { return X_WT.p - half * w; }  // m, position of the free end
  };
  /// The instrument's pose, and the ball of filling that it adds there.
  struct Portion {
    Pose X_WT;
    dvec3 center;  // m, centre of the ball of filling
    // excess[k]: cost of unwanted filling in a ball of filling with a radius of k + 1 voxels. wanted: for each k and
    // each height, number of voxels up to this height that lack filling.
    std::vector<double> excess, wanted;
    // Heights in `wanted`, m along the axis: the lowest height, and the distance between successive heights.
    double lowest = 0, step = 0;
    std::size_t level(double height) const {
      return static_cast<std::size_t>(
          std::clamp((height - lowest) / step, 0.0, 2.0 * static_cast<double>(excess.size()) - 1));
    }
  };
  /// A position of the instrument (m along u and v), and the portion of filling that can be added at this position.
  struct Spot {
    double a = 0, b = 0;
    std::optional<Portion> portion;
  };

  /// Plans portions for the lowest voxels first, because filling above these voxels would make them unreachable.
  void fill_with(std::uint32_t which) {
    const haptics::Tool& tool = tools_[which];
    session::Preparation layer = preparation();
    excess_costs_ = std::vector<std::atomic<double>>(layer.after.distance.size());
    const Instrument instrument(tool, axis_);
    std::vector<Spot> spots = spots_for(which, instrument, layer);
    const double above = top_of(layer.frame, layer.after) + instrument.half + Filling::hop_over;
    int portions = 0;
    for (const dvec3& q : lowest_first(layer)) {
      const glm::ivec3 v(q);
      // Skips voxels that an earlier portion of this plan fills.
      if (!to_fill(layer, layer.after.at(v.x, v.y, v.z))) continue;
      double radius = 0;  // voxels, radius of the ball of filling
      const Portion* const best = best_for(q, layer, instrument, spots, radius);
      if (!best) continue;
      const Portion portion = *best;
      radius *= layer.frame.voxel;
      const haptics::Fill ball(tool, portion.center, radius, portion.X_WT, layer.frame);
      const double volume = put(ball, layer);
      if (volume < Filling::min_volume) continue;
      state_.fill(haptics::Fill(tool, portion.center, radius, portion.X_WT, state_.frame()));
      filled_.push_back({which, glm::dot(portion.X_WT.p, instrument.u), glm::dot(portion.X_WT.p, instrument.v)});
      if (portions++ == 0) take(which, false);
      hop(portion.X_WT, above);
      press(instrument, portion.X_WT, volume);
      withdraw(instrument, portion, radius, layer);
      if (portions == Filling::at_once) break;
      const double a = glm::dot(portion.center, instrument.u), b = glm::dot(portion.center, instrument.v);
      for (Spot& spot : spots) {
        if (std::hypot(spot.a - a, spot.b - b) < 2 * tool.fill_reach)
          spot.portion = portion_at(instrument, layer, spot.a, spot.b);
      }
    }
    if (portions > 0) lift();
  }

  /// Presses the pedal until `volume` (m³) is filled.
  void press(const Instrument& instrument, const Pose& X_WT, double volume) {
    pedal_ = 1;
    add(ExpertLeg::Kind::kWait, X_WT, Filling::longer * volume / instrument.tool.fill_rate + Filling::min_time, volume);
    pedal_ = 0;
  }

  /// Raises the instrument in steps. At each step, fills the hole that the instrument leaves with a small ball. An
  /// unfilled hole would be covered by later portions.
  void withdraw(const Instrument& instrument, const Portion& from, double radius, session::Preparation& layer) {
    const haptics::Tool& tool = instrument.tool;
    const double voxel = layer.frame.voxel, hole = tool.radius() + haptics::Fill::kClear * voxel;
    const double a = glm::dot(from.X_WT.p, instrument.u), b = glm::dot(from.X_WT.p, instrument.v),
                 first = glm::dot(from.X_WT.p, instrument.w),
                 top = glm::dot(from.center, instrument.w) + radius + instrument.half;
    for (int step = 1; first + step * Filling::rise < top; ++step) {
      const auto portion = portion_standing(instrument, layer, a, b, first + step * Filling::rise);
      if (!portion) return;
      const double gap = glm::length(instrument.end(portion->X_WT) - portion->center);
      const double small = std::hypot(hole, gap) + Filling::whole_voxel * voxel;
      const double volume = put(haptics::Fill(tool, portion->center, small, portion->X_WT, layer.frame), layer);
      if (volume < Filling::min_volume) continue;
      state_.fill(haptics::Fill(tool, portion->center, small, portion->X_WT, state_.frame()));
      add(ExpertLeg::Kind::kMove, portion->X_WT);
      press(instrument, portion->X_WT, volume);
    }
  }

  /// Centres of voxels that lack filling, lowest first.
  std::vector<dvec3> lowest_first(const session::Preparation& in) const {
    std::vector<std::pair<double, dvec3>> by_height;
    for_each_voxel(in.after.size, [&](int x, int y, int z) {
      if (!to_fill(in, in.after.at(x, y, z))) return;
      const dvec3 q(x, y, z);
      by_height.push_back({glm::dot(in.frame.to_world(q), axis_), q});
    });
    std::stable_sort(by_height.begin(), by_height.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<dvec3> voxels;
    for (const auto& [height, q] : by_height) voxels.push_back(q);
    return voxels;
  }

  /// Best portion for voxel q, with its radius in voxels; null if no portion is a gain. Gain: missing volume up to
  /// Filling::layer above q, minus the cost of excess. Filling higher up would block the instrument.
  const Portion* best_for(const dvec3& q, const session::Preparation& in, const Instrument& instrument,
                          const std::vector<Spot>& spots, double& radius) const {
    const Portion* best = nullptr;
    double most = 0;
    for (const Spot& spot : spots) {
      if (!spot.portion) continue;
      const Portion& portion = *spot.portion;
      const double least = glm::length(q - in.frame.to_voxels(portion.center)) + Filling::whole_voxel;
      const dvec3 p_TQ = glm::conjugate(instrument.R_WT) * (in.frame.to_world(q) - portion.X_WT.p);
      if (instrument.field.distance(p_TQ) <= Filling::head_free * in.frame.voxel) continue;
      const std::size_t level = portion.level(glm::dot(in.frame.to_world(q), axis_) + Filling::layer);
      for (std::size_t k = 0; k < portion.excess.size(); ++k) {
        const double r = std::min(static_cast<double>(k + 1), max_radius(in, instrument));
        const double gain = portion.wanted[2 * portion.excess.size() * k + level] - portion.excess[k];
        if (r < least || gain <= most) continue;
        most = gain;
        radius = r;
        best = &portion;
      }
    }
    return best;
  }
  /// Largest radius of a ball of filling that the instrument can add, voxels.
  static double max_radius(const session::Preparation& in, const Instrument& instrument) {
    return Filling::portion_radius * instrument.tool.fill_reach / in.frame.voxel;
  }

  /// Adds the ball of filling to planned tissue. Returns its volume, m³.
  static double put(const haptics::Fill& ball, session::Preparation& layer) {
    const glm::ivec3 from = glm::max(ball.lo(), glm::ivec3(0)), to = glm::min(ball.hi(), layer.after.size - 1);
    if (glm::any(glm::lessThan(to, from))) return 0;
    const std::size_t at = layer.after.at(from.x, from.y, from.z), row = static_cast<std::size_t>(layer.after.size.z);
    PerTissue added{};
    ball.lower(from, to - from + 1, &layer.after.distance[at], &layer.tissue[at],
               row * static_cast<std::size_t>(layer.after.size.y), row, &added);
    return total(added) * std::pow(layer.frame.voxel, 3);
  }

  /// Grid of positions of the instrument above the voxels that lack filling, and its earlier positions.
  std::vector<Spot> spots_for(std::uint32_t which, const Instrument& instrument,
                              const session::Preparation& layer) const {
    glm::dvec2 lo(1e9), hi(-1e9);
    for_each_voxel(layer.after.size, [&](int x, int y, int z) {
      if (!to_fill(layer, layer.after.at(x, y, z))) return;
      const dvec3 p = layer.frame.to_world(dvec3(x, y, z));
      const glm::dvec2 q(glm::dot(p, instrument.u), glm::dot(p, instrument.v));
      lo = glm::min(lo, q), hi = glm::max(hi, q);
    });
    const double edge = 0.5 * instrument.tool.fill_reach;
    std::vector<Spot> spots;
    for (double b = lo.y - edge; b <= hi.y + edge; b += Filling::grid)
      for (double a = lo.x - edge; a <= hi.x + edge; a += Filling::grid) spots.push_back({a, b, {}});
    for (const FilledSpot& filled : filled_)
      if (filled.tool == which) spots.push_back({filled.a, filled.b, {}});
    in_parallel(
        spots.size(), [&](std::size_t k) { spots[k].portion = portion_at(instrument, layer, spots[k].a, spots[k].b); },
        {}, /*block=*/1);
    return spots;
  }

  /// Lowers the instrument to the tissue, then lifts it by the height of a portion.
  std::optional<Portion> portion_at(const Instrument& instrument, const session::Preparation& layer, double a,
                                    double b) const {
    const double half = instrument.half, reach = instrument.tool.fill_reach, h = layer.frame.voxel;
    const auto at = [&](double c) { return a * instrument.u + b * instrument.v + c * instrument.w; };
    const auto end = [&](double c) { return layer.frame.to_voxels(at(c - half)); };
    // Distance in voxels from the head at height c to the tissue, minus the gap to keep (Filling::free); at least 0.
    const auto room = [&](double c) {
      double least = 1e9;
      for (const dvec3& p : instrument.head) {
        least = std::min(least, layer.after.sample(layer.frame.to_voxels(at(c) + p)) - Filling::free);
        if (least <= 0) return 0.0;
      }
      return least;
    };
    const auto clear = [&](double c) { return room(c) > 0; };
    const dvec3 size = dvec3(layer.after.size - 1) * h;
    const double middle = glm::dot(layer.frame.to_world(dvec3(layer.after.size - 1) * 0.5), instrument.w),
                 span = 0.5 * glm::length(size);
    double c = middle + span + half;
    while (c > middle - span) {
      const double below = room(c - Filling::down);
      if (below <= 0) break;
      // The step is larger if the tissue below is farther away.
      c -= Filling::down * (1 + std::floor(Filling::trusted * below * h / Filling::down));
    }
    // Moves the instrument towards a near wall, because the slit between instrument and wall would remain unfilled.
    dvec3 aside = layer.after.gradient(end(c + reach));
    aside -= glm::dot(aside, instrument.w) * instrument.w;
    if (layer.after.sample(end(c + reach)) * h < instrument.tool.radius() + Filling::near_wall &&
        glm::length(aside) > Filling::one_surface) {
      const dvec3 step = Filling::nudge * glm::normalize(aside);
      for (double moved = 0; moved < Filling::near_wall; moved += Filling::nudge) {
        a -= glm::dot(step, instrument.u), b -= glm::dot(step, instrument.v);
        if (clear(c)) continue;
        a += glm::dot(step, instrument.u), b += glm::dot(step, instrument.v);
        break;
      }
    }
    const double height = std::min(Filling::portion_height * reach, Filling::below_wall * instrument.tool.radius());
    for (const double from = c; way_down(instrument, layer, end(c)) < height && c < from + height;
         c += 0.5 * Filling::down) {
      if (layer.ideal.sample(end(c)) * h > (over_ ? Filling::overfill : Filling::proud)) break;
    }
    return portion_standing(instrument, layer, a, b, c);
  }

  /// The portion with the head's centre at (a, b, c). The centre of its ball of filling is the surface point nearest to
  /// the free end; midway between two walls, the point straight below that end. Empty if no surface is in reach.
  std::optional<Portion> portion_standing(const Instrument& instrument, const session::Preparation& layer, double a,
                                          double b, double c) const {
    const double reach = instrument.tool.fill_reach;
    const Pose X_WT{a * instrument.u + b * instrument.v + c * instrument.w, instrument.R_WT};
    dvec3 center = instrument.end(X_WT);
    const dvec3 end = layer.frame.to_voxels(center), g = layer.after.gradient(end);
    const double gap = layer.after.sample(end) * layer.frame.voxel;
    if (gap <= 0 || gap > reach) return std::nullopt;
    if (glm::length(g) >= Filling::one_surface) {
      center -= gap * glm::normalize(g);
    } else {
      const double way = way_down(instrument, layer, end);
      if (way >= reach) return std::nullopt;
      center -= way * instrument.w;
    }
    Portion portion{X_WT, center, {}, {}};
    measure(layer, instrument, portion);
    return portion;
  }

  /// Distance from p (voxels) straight down to the tissue, m; at most the instrument's reach.
  static double way_down(const Instrument& instrument, const session::Preparation& layer, const dvec3& p) {
    const double reach = instrument.tool.fill_reach;
    double way = 0;
    while (way < reach && layer.after.sample(p - way / layer.frame.voxel * instrument.w) > 0) way += Filling::down;
    return way;
  }

  void measure(const session::Preparation& in, const Instrument& instrument, Portion& portion) const {
    const dvec3 c = in.frame.to_voxels(portion.center);
    const double most = max_radius(in, instrument);
    const dquat R_TW = glm::conjugate(instrument.R_WT);
    const glm::ivec3 lo = glm::max(glm::ivec3(glm::ceil(c - most)), glm::ivec3(0)),
                     hi = glm::min(glm::ivec3(glm::floor(c + most)), in.after.size - 1);
    const std::size_t bins = static_cast<std::size_t>(most) + 1, levels = 2 * bins;
    portion.lowest = glm::dot(portion.center, instrument.w) - static_cast<double>(bins) * in.frame.voxel;
    portion.step = in.frame.voxel;
    portion.excess.assign(bins, 0);
    portion.wanted.assign(bins * levels, 0);
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
      const dvec3 p(x, y, z);
      const double away = glm::length(p - c);
      const std::size_t i = in.after.at(x, y, z);
      if (away > most || in.after.distance[i] <= 0) return;
      if (instrument.field.distance(R_TW * (in.frame.to_world(p) - portion.X_WT.p)) <=
          Filling::head_free * in.frame.voxel)
        return;
      const auto k = static_cast<std::size_t>(away);
      if (to_fill(in, i)) {
        portion.wanted[k * levels + portion.level(glm::dot(in.frame.to_world(p), instrument.w))] += 1;
      } else {
        portion.excess[k] += excess_cost(in, i, p);
      }
    });
    std::partial_sum(portion.excess.begin(), portion.excess.end(), portion.excess.begin());
    for (std::size_t k = 0; k < bins; ++k) {
      double* const row = &portion.wanted[k * levels];
      std::partial_sum(row, row + levels, row);
      for (std::size_t j = 0; k > 0 && j < levels; ++j) row[j] += row[j - levels];
    }
  }

  /// Cost of unwanted filling in voxel i at p. The portions of a layer share most voxels, so each cost is computed
  /// once.
  double excess_cost(const session::Preparation& in, std::size_t i, const dvec3& p) const {
    double cost = excess_costs_[i].load(std::memory_order_relaxed);
    if (cost > 0) return cost;
    cost = computed_excess_cost(in, p);
    excess_costs_[i].store(cost, std::memory_order_relaxed);
    return cost;
  }
  /// The cost is low over the cavity, where filling is carved away later.
  double computed_excess_cost(const session::Preparation& in, const dvec3& p) const {
    const dvec3 g = in.ideal.gradient(p);
    const double slope = glm::length(g);
    if (slope < Filling::one_surface) return Filling::flash;
    const dvec3 below = p - (in.ideal.sample(p) + Filling::rim) / slope * g;
    return in.before.sample(below) > 0 ? over_ ? Filling::overfilled : Filling::carved_again : Filling::flash;
  }

  /// True if voxel i is empty now, inside the target shape, and in the volume that the task changes.
  static bool to_fill(const session::Preparation& in, std::size_t i) {
    return in.after.distance[i] > 0 && in.ideal.distance[i] < 0 && in.ideal.distance[i] < in.before.distance[i] - 0.2f;
  }

  /// Height of the tissue's highest point along the axis, m.
  double top_of(const VoxelFrame& frame, const session::DenseField& field) const {
    double top = -1e9;
    for_each_voxel(field.size, [&](int x, int y, int z) {
      if (field.distance[field.at(x, y, z)] < 0) top = std::max(top, glm::dot(frame.to_world(dvec3(x, y, z)), axis_));
    });
    return top;
  }

  const ExpertGrip grip_;
  const session::Preparation& compared_;
  double whole_;  // m³, volume that differs from the ideal shape at the start
  std::vector<FilledSpot>& filled_;
  mutable std::vector<std::atomic<double>> excess_costs_;  // of each voxel of the layer; 0: not yet computed
  const SurroundingsShape* around_;
  std::span<const haptics::Tool> tools_;
  const double run_up_time_;  // s, time constant of the drill's speed
  const TaskEvaluator& judge_;
  haptics::TissueVolume state_;
  session::DenseField ideal_, true_ideal_;  // target shape in the box of the last cut; with true distances
  dvec3 axis_;
  // Heights along the preparation's axis, m: top of the tissue; free motion of the tool above it.
  double top_ = -1e9, above_ = -1e9;
  std::vector<ExpertLeg> legs_;
  double pedal_ = 0;
  double force_ = 0;  // N, force of the next cuts
  std::uint32_t tool_ = 0;
  // True in the second pass of filling, which may rise above the contour and is carved later.
  bool over_ = false;
};

}  // namespace

Expert::Expert(const Scene& scene, const haptics::TissueVolume& start, const PlanMargins& margins)
    : scene_(scene),
      grip_(grip_of(scene, start.frame().voxel, margins)),
      judge_(scene, start),
      around_(monitored_shape(scene.surroundings)),
      whole_(0) {
  if (!judge_.has_ideal()) {
    throw Error(scene.file.string(), "\"task\"", "no \"ideal\"", "a task that says how it should be left");
  }
  const session::Preparation work = judge_.preparation(start);
  whole_ = remaining_difference(work.after, work.ideal, work.frame.voxel);
}

std::vector<ExpertLeg> Expert::plan(const haptics::TissueVolume& now) {
  const session::Preparation compared = judge_.preparation(now);
  Plan plan(scene_, grip_, now, compared, judge_, around_ ? &*around_ : nullptr, whole_, filled_);
  // After several layers that added hardly any filling, the next instrument is used, which has a longer reach.
  const double missing = missing_in(compared.after, compared.ideal, compared.frame.voxel);
  useless_layers_ = missing > missing_ - Rounds::min_layer ? useless_layers_ + 1 : 0;
  missing_ = std::min(missing_, missing);
  if (useless_layers_ > Rounds::max_vain) useless_layers_ = 0, ++instrument_;
  if (cuts_ == 1 && layers_ > layers_cut_ && layers_cut_ == 0) {
    // Second pass of filling, after the first carving: fills what is missing, and more.
    layers_cut_ = layers_;
    instrument_ = plan.fillers();
    useless_layers_ = 0;
    missing_ = missing;
  }
  if (cuts_ <= (layers_cut_ > 0 ? 1 : 0)) {
    while (plan.idle() && instrument_ < 2 * plan.fillers()) {
      plan.fill(instrument_ % plan.fillers(), /*over=*/instrument_ >= plan.fillers());
      if (plan.idle()) ++instrument_;
    }
  }
  std::vector<ExpertLeg> legs = plan.take_legs();
  const double off = remaining_difference(compared.after, compared.ideal, compared.frame.voxel),
               still_left = plan.has_deposit() ? Rounds::still_left_of_deposit : Rounds::still_left;
  if (!legs.empty()) {
    ++layers_;
  } else if (cuts_ < Rounds::max_cuts && (cuts_ == 0 || layers_ > layers_cut_ || off < still_left * off_)) {
    if (layers_ > 0 && cuts_ == 0)
      log::info("filled in {} layers: {:.2f} mm³ missing, {:.2f} mm³ too much", layers_, missing * 1e9,
                (off - missing) * 1e9);
    plan.cut(/*by_hand=*/false);
    // If filling continues after this first carving, the carving does not remove thin layers of excess filling.
    const bool filling_resumes = layers_ > 0 && cuts_ == 0;
    plan.cut(/*by_hand=*/true, filling_resumes ? grip_.size * Rounds::clearly_too_high : 0);
    legs = plan.take_legs();
    if (!legs.empty()) ++cuts_;
    if (cuts_ > 1) layers_cut_ = layers_;
    off_ = off;
  }
  planned_ = plan.take_state();
  if (legs.empty() && layers_ + cuts_ == 0) {
    throw Error(scene_.file.string(), "\"tools\"", "no tool that brings the tissue nearer to the task's ideal",
                "one that cuts or fills there");
  }
  return legs;
}

}  // namespace typodont
