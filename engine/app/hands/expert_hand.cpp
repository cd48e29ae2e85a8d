#include "engine/app/hands/expert_hand.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/app/hands/task_student.h"
#include "engine/app/task/task.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "haptics/fill.h"

namespace typodont {

namespace {

constexpr double kTravel = 40e-3;        // m/s in the air
constexpr double kCutPace = 8e-3;        // m/s along a stroke where nothing is in the way
constexpr double kScrapePace = 12e-3;    // m/s of an edge drawn by hand
constexpr double kAhead = 0.045e-3;      // m that the wanted place may lead the tool
constexpr double kThere = 0.02e-3;       // m
constexpr double kNearLine = 0.05e-3;    // m, the same for an edge: so near the line is good enough
constexpr int kMostTimes = 8;            // along one line with an edge
constexpr double kAllowance = 0.045e-3;  // m farther than wanted: so much less than asked for does a bur do
constexpr double kPatience = 1.2;        // s without getting on before it leaves a stroke
constexpr double kScrapeGain = 8, kMostScrapeLead = 0.5e-3;  // the same of an edge in soft filling
constexpr double kGain = 25;             // lead over how far the tool is off: how hard it presses
constexpr double kMostLead = 1.6e-3;     // m
constexpr double kReactionTime = 0.05;   // s
constexpr double kJoined = 0.6e-3;       // m; strokes that lie nearer are joined without lifting
constexpr double kAbove = 1.0e-3;        // m over everything, to travel
constexpr double kAside = 0.06e-3;       // m
constexpr double kLeastPortion = 0.01e-9; // m³ of filling that is worth its way
constexpr double kMostFilling = 0.5;     // s at one place
constexpr double kRunUp = 1.0;           // s for the drill
constexpr double kWorthIt = 0.9;         // another tool must leave less than this share of what the last one left
constexpr double kLeastGain = 0.03;      // of the whole task, that a tool must bring
constexpr int kMostRounds = 4;           // of doing and looking
constexpr std::size_t kMostTools = 3;
constexpr std::size_t kMostTried = 5;

/// m³ of tissue too much and too little.
double left_to_do(const session::Preparation& in) {
  double sum = 0;
  for (std::size_t i = 0; i < in.after.distance.size(); ++i) {
    sum += std::abs(session::share_inside(static_cast<double>(in.after.distance[i])) -
                    session::share_inside(static_cast<double>(in.ideal.distance[i])));
  }
  return sum * in.frame.voxel * in.frame.voxel * in.frame.voxel;
}

class Plan {
 public:
  Plan(const Scene& scene, const haptics::TissueVolume& start, const TaskJudge& judge, double whole)
      : whole_(whole), tools_(haptics::tray(scene.servo)), judge_(judge), state_(start.clone()), axis_(glm::normalize(scene.task->axis_W)) {
    glm::ivec3 lo, hi;
    start.bounds(lo, hi);
    for (int corner = 0; corner < 8; ++corner) {
      const dvec3 p = start.frame().to_world(dvec3(corner & 1 ? hi.x : lo.x, corner & 2 ? hi.y : lo.y, corner & 4 ? hi.z : lo.z));
      top_ = std::max(top_, glm::dot(p, axis_));
    }
    for (const haptics::Tool& tool : tools_) above_ = std::max(above_, top_ + tool.reach() + kAbove);
  }

  /// With the tool that leaves least, then with others as long as they bring it nearer.
  void cut(bool by_hand) {
    std::vector<bool> used(tools_.size());
    for (std::size_t round = 0; round < kMostTools; ++round) {
      session::Preparation now = judge_.preparation(state_);
      const double before = left_to_do(now);
      now.before = now.after;  // what is to go is what is there now
      double best = std::min(kWorthIt * before, before - kLeastGain * whole_);
      std::size_t which = tools_.size(), tried = 0;
      std::vector<Stroke> strokes;
      for (std::size_t i = 0; i < tools_.size(); ++i) {
        const haptics::Tool& tool = tools_[i];
        if (used[i] || !tool.cuts || tool.turns() == by_hand || ++tried > kMostTried) continue;
        std::vector<Stroke> candidate = plan_strokes(now, tool, std::clamp(0.3 * tool.diameter, 0.12e-3, 0.35e-3),
                                                     by_hand ? 0 : kAllowance);
        haptics::TissueVolume after = state_.clone();
        carve_strokes(after, tool, candidate);
        const double left = left_to_do(judge_.preparation(after));
        if (left >= best) continue;
        best = left;
        which = i;
        strokes = std::move(candidate);
      }
      if (which == tools_.size()) return;
      used[which] = true;
      log::info("{}: {} strokes, from {:.2f} to {:.2f} mm³ off", tools_[which].name, strokes.size(), before * 1e9, best * 1e9);
      carve_strokes(state_, tools_[which], strokes);
      take(static_cast<std::uint32_t>(which), !by_hand);
      for (const Stroke& s : strokes) {
        if (legs_.empty() || glm::length(s.from.p - legs_.back().to.p) > kJoined) go_over(s.from);
        add(ExpertLeg::Kind::kCut, s.from);
        add(by_hand ? ExpertLeg::Kind::kScrape : ExpertLeg::Kind::kCut, s.to);
      }
      lift();
    }
  }

  /// Puts filling into what should be full, layer upon layer, until it stands above the contour everywhere.
  void fill() {
    std::size_t finest = tools_.size();
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      if (tools_[i].fill == Tissue::kAir) continue;
      if (finest == tools_.size() || tools_[i].fill_reach < tools_[finest].fill_reach) finest = i;
    }
    if (finest < tools_.size()) fill_with(static_cast<std::uint32_t>(finest));
  }

  std::vector<ExpertLeg> take_legs() { return std::move(legs_); }
  haptics::TissueVolume take_state() { return std::move(state_); }

 private:
  void add(ExpertLeg::Kind kind, const Pose& to, double seconds = 0, double volume = 0) {
    legs_.push_back({kind, to, pedal_, tool_, seconds, volume});
  }
  Pose over(Pose pose) const {
    pose.p += (above_ - glm::dot(pose.p, axis_)) * axis_;
    return pose;
  }
  void lift() {
    if (!legs_.empty()) add(ExpertLeg::Kind::kMove, over(legs_.back().to));
  }
  void go_over(const Pose& to) {
    lift();
    add(ExpertLeg::Kind::kMove, over(to));
  }
  /// Up, across and down: what was just put down lies between.
  void hop(const Pose& to, double by) {
    Pose up = legs_.back().to, across = to;
    const double height = std::max(glm::dot(up.p, axis_), glm::dot(to.p, axis_)) + by;
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
    if (drill) add(ExpertLeg::Kind::kWait, here, kRunUp);
  }

  void fill_with(std::uint32_t which) {
    const haptics::Tool& tool = tools_[which];
    const Pose upright{dvec3(0), toward(axis_)};
    const dvec3 u = upright.R * dvec3(1, 0, 0), v = upright.R * dvec3(0, 1, 0), w = upright.R * dvec3(0, 0, 1);
    const double half = tool.shape == haptics::HeadShape::kSphere ? tool.radius() : tool.length / 2;
    const double reach = tool.fill_reach, spacing = 0.6 * reach;
    std::vector<dvec3> head;
    for (const haptics::HeadSample& sample : haptics::sample_head(tool, 60)) head.push_back(upright.R * sample.p_TQ);

    session::Preparation layer = judge_.preparation(state_);  // and what was filled since
    dvec3 lo(1e9), hi(-1e9);
    const glm::ivec3 n = layer.after.size;
    for (int x = 0; x < n.x; ++x) {
      for (int y = 0; y < n.y; ++y) {
        for (int z = 0; z < n.z; ++z) {
          const std::size_t i = layer.after.at(x, y, z);
          if (layer.after.distance[i] < 0 || layer.ideal.distance[i] >= 0) continue;
          const dvec3 p = layer.frame.to_world(dvec3(x, y, z)), q(glm::dot(p, u), glm::dot(p, v), glm::dot(p, w));
          lo = glm::min(lo, q), hi = glm::max(hi, q);
        }
      }
    }
    if (lo.x > hi.x) return;
    bool taken = false;
    for (double c = lo.z; c <= hi.z + 0.6 * reach; c += 0.5 * spacing) {
      for (double b = lo.y; b <= hi.y + 0.5 * spacing; b += spacing) {
        for (double a = lo.x; a <= hi.x + 0.5 * spacing; a += spacing) {
          const dvec3 end = a * u + b * v + c * w;  // of the instrument
          const dvec3 q = layer.frame.to_voxels(end);
          // Over or inside what is to be filled, in the open, with something in reach to put it on, and not yet standing
          // above the contour here.
          const double ideal = layer.ideal.sample(q) * layer.frame.voxel, is = layer.after.sample(q) * layer.frame.voxel;
          if (is < -0.4 * reach || is > 0.8 * reach || ideal > 0.6 * reach) continue;
          bool below = false;  // something is to be filled within the dome
          for (double depth = 0; depth < reach && !below; depth += 0.1e-3) {
            const dvec3 p = layer.frame.to_voxels(end - depth * w);
            below = layer.ideal.sample(p) < 0.5 && layer.after.sample(p) > 0 && opening(layer, p);
          }
          if (!below) continue;
          // The head beside it where a wall is in its way.
          Pose X_WT{end + half * w, upright.R};
          const auto clear = [&] {
            return std::all_of(head.begin(), head.end(), [&](const dvec3& h) {
              return layer.after.sample(layer.frame.to_voxels(X_WT.p + h)) > -0.1;
            });
          };
          bool fits = clear();
          for (double aside = 0; !fits && aside < tool.radius() + spacing; aside += kAside) {
            const dvec3 slope = layer.after.gradient(layer.frame.to_voxels(X_WT.p - (half - tool.radius()) * w), 2);
            const dvec3 level = slope - glm::dot(slope, w) * w;
            if (!(glm::length(level) > 0.1)) break;
            X_WT.p += kAside * glm::normalize(level);
            fits = clear();
          }
          if (!fits) continue;
          const dvec3 at_end = layer.frame.to_voxels(X_WT.p - half * w), g = layer.after.gradient(at_end);
          const double gap = layer.after.sample(at_end) * layer.frame.voxel;
          if (gap < 0.05e-3 || gap > 0.8 * reach || !(glm::length(g) > 0.3)) continue;
          const dvec3 center = X_WT.p - half * w - gap * glm::normalize(g);
          const haptics::Fill dome(tool, center, 0.9 * reach, X_WT, layer.frame);
          const glm::ivec3 from = glm::max(dome.lo(), glm::ivec3(0)), to = glm::min(dome.hi(), n - 1);
          if (glm::any(glm::lessThan(to, from))) continue;
          const std::size_t at = layer.after.at(from.x, from.y, from.z), row = static_cast<std::size_t>(n.z);
          PerTissue added{};
          dome.lower(from, to - from + 1, &layer.after.distance[at], &layer.tissue[at], row * static_cast<std::size_t>(n.y), row, &added);
          const double volume = std::accumulate(added.begin(), added.end(), 0.0) * std::pow(layer.frame.voxel, 3);
          if (volume < kLeastPortion) continue;
          state_.fill(haptics::Fill(tool, center, 0.9 * reach, X_WT, state_.frame()));
          if (!taken) take(which, false);
          taken = true;
          hop(X_WT, 1.6 * reach);
          pedal_ = 1;
          add(ExpertLeg::Kind::kWait, X_WT, kMostFilling, volume);
          pedal_ = 0;
        }
      }
    }
    if (taken) lift();
  }

  /// Open at the start of the task at this place: what is to be filled, not what only lies outside the tooth.
  static bool opening(const session::Preparation& in, const dvec3& p) { return in.ideal.sample(p) < in.before.sample(p) - 0.2; }

  double whole_;  // m³
  std::span<const haptics::Tool> tools_;
  const TaskJudge& judge_;
  haptics::TissueVolume state_;
  dvec3 axis_;
  double top_ = -1e9, above_ = -1e9;  // m along the axis
  std::vector<ExpertLeg> legs_;
  double pedal_ = 0;
  std::uint32_t tool_ = 0;
};

}  // namespace

Expert::Expert(const Scene& scene, const haptics::TissueVolume& start) : scene_(scene), judge_(scene, start), whole_(0) {
  if (!judge_.has_ideal()) {
    throw Error(scene.file.string(), "\"task\"", "no \"ideal\"", "a task that says how it should be left");
  }
  whole_ = left_to_do(judge_.preparation(start));
}

std::vector<ExpertLeg> Expert::plan(const haptics::TissueVolume& now) {
  Plan plan(scene_, now, judge_, whole_);
  plan.fill();
  plan.cut(/*by_hand=*/false);
  plan.cut(/*by_hand=*/true);
  std::vector<ExpertLeg> legs = plan.take_legs();
  planned_ = plan.take_state();
  if (legs.empty() && plans_ == 0) {
    throw Error(scene_.file.string(), "\"tools\"", "no tool that brings the tissue nearer to the task's ideal", "one that cuts or fills there");
  }
  ++plans_;
  return legs;
}

void run_expert(HapticLoop& loop, ExpertHand& hand, Expert& expert, const std::function<void(const ServoTick&, const Cut*)>& each) {
  for (int round = 0; round < kMostRounds; ++round) {
    loop.run(hand, [&](const ServoTick& tick, const Cut* cut) {
      each(tick, cut);
      hand.see(tick);
    });
    std::vector<ExpertLeg> rest = expert.plan(loop.carver().volume());
    if (rest.empty()) return;
    hand.go_on(std::move(rest));
  }
}

void ExpertHand::go_on(std::vector<ExpertLeg> legs) {
  legs_ = std::move(legs);
  leg_ = 0;
  along_ = waited_ = worst_ = 0;
  times_ = 0;
}

ExpertHand::ExpertHand(std::vector<ExpertLeg> legs, double rate) : legs_(std::move(legs)), dt_(1 / rate), from_(legs_.front().to) {
  info_.address = "expert:";
  info_.model = "a hand that knows the task";
  info_.rate = rate;
  seen_.X_WG = seen_.X_WT = from_;
}

void ExpertHand::next_leg() noexcept {
  from_ = legs_[leg_].to;
  ++leg_;
  along_ = waited_ = worst_ = 0;
  times_ = 0;
}

bool ExpertHand::read(haptics::HandSample& sample) noexcept {
  if (leg_ >= legs_.size()) return false;
  using Kind = ExpertLeg::Kind;
  const ExpertLeg& leg = legs_[leg_];
  const bool back = leg.kind == Kind::kScrape && times_ % 2 == 1;
  const Pose &a = back ? leg.to : from_, &b = back ? from_ : leg.to;
  const double length = glm::length(b.p - a.p);
  const auto place = [&] { return length > 0 ? a.p + (along_ / length) * (b.p - a.p) : b.p; };
  double off = glm::length(place() - seen_.X_WG.p);
  waited_ += dt_;
  bool done = false;
  if (leg.kind == Kind::kWait) {
    along_ = length;
    const double now = -std::accumulate(seen_.removed.begin(), seen_.removed.end(), 0.0);
    if (waited_ < 1.5 * dt_) filled_ = now;
    done = waited_ >= leg.seconds || (leg.volume > 0 && now - filled_ >= leg.volume);
  } else if (leg.kind == Kind::kTake) {
    along_ = length;
    done = seen_.tool == leg.tool || waited_ > 10;
  } else {
    const double pace = leg.kind == Kind::kMove ? kTravel : leg.kind == Kind::kCut ? kCutPace : kScrapePace;
    const bool may = leg.kind != Kind::kCut || off < kAhead;
    if (may && along_ < length) {
      along_ = std::min(length, along_ + pace * dt_);
      waited_ = 0;
    }
    if (leg.kind == Kind::kScrape) worst_ = std::max(worst_, off);
    done = along_ >= length && (leg.kind != Kind::kCut || off < kThere);
    done = done || waited_ > kPatience;
    if (done && leg.kind == Kind::kScrape && worst_ > kNearLine && ++times_ < kMostTimes) {
      done = false;
      along_ = length - along_;
      if (along_ >= length) along_ = 0;
      worst_ = waited_ = 0;
    }
  }
  const bool presses = leg.kind == Kind::kCut || leg.kind == Kind::kScrape;
  const bool scrapes = leg.kind == Kind::kScrape;
  dvec3 wanted = presses ? (scrapes ? kScrapeGain : kGain) * (place() - seen_.X_WG.p) : dvec3(0);
  const double size = glm::length(wanted), most = scrapes ? kMostScrapeLead : kMostLead;
  if (size > most) wanted *= most / size;
  lead_ += std::min(1.0, dt_ / kReactionTime) * (wanted - lead_);
  const double share = length > 0 ? along_ / length : 1;
  sample.t = from_seconds(static_cast<double>(ticks_++) * dt_);
  sample.X_WT = {place() + lead_, glm::slerp(a.R, b.R, share)};
  sample.pedal = leg.pedal;
  sample.tool = leg.tool;
  if (done) next_leg();
  return true;
}

}  // namespace typodont
