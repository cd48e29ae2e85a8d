#include "engine/app/hands/expert_hand.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/app/hands/implant_expert.h"
#include "engine/app/hands/task_student.h"
#include "engine/app/recording/resume.h"
#include "engine/app/task/task.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"
#include "engine/base/units.h"
#include "haptics/fill.h"
#include "haptics/scripted_hand.h"

namespace typodont {

namespace {

constexpr double kTravel = 60e-3;      // m/s in the air
constexpr double kCutPace = 20e-3;     // m/s along a stroke where nothing is in the way
constexpr double kScrapePace = 30e-3;  // m/s of an edge drawn by hand
constexpr double kSlowing =
    0.06;  // s before a stroke's end: slower than the hand reacts, or it cuts on into what should stay
constexpr double kEndPace = 0.4e-3;      // m/s there
constexpr double kAhead = 0.05e-3;       // m that the wanted place may lead the tool along a cut …
constexpr double kBeside = 0.02e-3;      // … and that the tool may be beside it
constexpr double kThere = 0.01e-3;       // m
constexpr double kNearLine = 0.035e-3;   // m, the same for an edge: so near the line is good enough
constexpr int kMostTimes = 8;            // along one line with an edge
constexpr double kAllowance = 0.005e-3;  // m farther than wanted: so much less than asked for does a bur do
constexpr double kPass = 0.22, kLeastPass = 0.12e-3, kMostPass = 0.3e-3;  // of the diameter, m: between passes
constexpr double kPatience = 3;                               // s without getting on before it leaves a stroke
constexpr double kScrapeGain = 12, kMostScrapeLead = 1.5e-3;  // the same of an edge in soft filling
constexpr double kGain = 50;             // lead over how far the tool is off: how hard it presses, …
constexpr double kSteadyGain = 1.5;      // … and at most so many reaction times over the tick, or it would swing
constexpr double kWorkingForce = 1.8;    // N that a cut is pressed on with, …
constexpr double kLeadPerForce = 15e-3;  // … m/s of lead for each N that it is off, …
constexpr double kLeastMostLead = 0.6e-3, kMostLead = 4e-3;  // … m, within these
constexpr double kStraightOn = 0.9, kTurn = 0.3;             // cosines of a turn: no slower; somewhat slower
constexpr double kAsidePace = 5e-3, kTurnPace = 1.5e-3;      // m/s in a turn, and in a sharper one
constexpr double kReactionTime = 0.05;                       // s
constexpr double kNoGap = 1e-6;                              // m; strokes that lie nearer meet
constexpr double kJoined = 0.6e-3;                           // m; strokes that lie nearer are joined without lifting
constexpr double kAbove = 1.0e-3;                            // m over everything, to travel
constexpr double kHopOver = 0.3e-3;                          // m over the tissue, from portion to portion
constexpr double kFillGrid = 0.15e-3;                        // m between places looked at for filling
constexpr int kHeadPoints = 120;
constexpr double kDown = 0.04e-3;  // m, how finely it is looked how far an instrument comes down
constexpr double kFree = 0.1;      // voxels that stay between it and what it comes down on
constexpr double kPortionHeight = 0.6, kLayer = 0.3, kPortionRadius = 0.98;  // shares of the instrument's reach
constexpr double kBelowWall = 0.8;  // of the instrument's radius: lower, so that the nearest surface is not the wall's
constexpr double kNearWall = 0.2e-3, kNudge = 0.02e-3;  // m: so near a wall it is put against it, in such steps
constexpr double kHeadFree = 0.5;                       // voxels that a portion leaves between itself and the head
constexpr double kOneSurface = 0.5;  // slope of the field below which a place lies midway between surfaces
constexpr double kProud = 0.12e-3, kOverfill = 0.4e-3;    // m that an instrument's end stands above the contour at most
constexpr double kCarvedAgain = 0.4, kOverfilled = 0.05;  // what is too much counts so much of what is wanted
constexpr double kWorthPortion = 0.003e-9,
                 kWorthOverfill = 0.03e-9;   // m³ that is wanted at a place and worth a portion
constexpr double kMostFilling = 0.5;         // s at one place
constexpr double kRunUp = 1.0;               // s for the drill
constexpr double kHardlyMore = 0.12;         // of what the best tool takes away, that a wider one may leave
constexpr double kHardlyLess = 0.7;          // of what a tool leaves: where another one leaves less, it finishes
constexpr double kSameWidth = 0.01e-3;       // m
constexpr double kWorthIt = 0.9;             // another tool must leave less than this share of what the last one left
constexpr double kLeastGain = 0.012;         // of the whole task, that a tool must bring
constexpr double kWorthCutting = 0.5;        // of what was off before: where more is left, it is not cut once more
constexpr double kLeastLayer = 0.01e-9;      // m³ that a layer must bring
constexpr int kMostVain = 3, kMostCuts = 4;  // of doing and looking
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

/// m³ that should be full and are not.
double missing_in(const session::Preparation& in) {
  double sum = 0;
  for (std::size_t i = 0; i < in.after.distance.size(); ++i) {
    sum += std::max(0.0, session::share_inside(static_cast<double>(in.ideal.distance[i])) -
                             session::share_inside(static_cast<double>(in.after.distance[i])));
  }
  return sum * in.frame.voxel * in.frame.voxel * in.frame.voxel;
}

/// m, over the length of the head.
double mean_width(const haptics::Tool& tool) {
  constexpr int kPlaces = 16;
  double sum = 0;
  for (int k = 0; k < kPlaces; ++k) sum += 2 * tool.profile(tool.half() * (2 * (k + 0.5) / kPlaces - 1));
  return sum / kPlaces;
}

class Plan {
 public:
  Plan(const Scene& scene, const haptics::TissueVolume& now, const TaskJudge& judge, const SurroundingsShape* around,
       double whole)
      : whole_(whole),
        around_(around),
        tools_(haptics::tool_set(scene.servo)),
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
    for (const haptics::Tool& tool : tools_) above_ = std::max(above_, top_ + tool.reach() + kAbove);
  }

  /// With the widest tool that leaves hardly more than the best, for it cuts fastest; then with others as long as they
  /// bring it nearer.
  void cut(bool by_hand) {
    std::vector<bool> used(tools_.size());
    for (std::size_t round = 0; round < kMostTools; ++round) {
      session::Preparation now = judge_.preparation(state_);
      const double before = left_to_do(now);
      now.before = now.after;  // what is to go is what is there now
      const double most = std::min(kWorthIt * before, before - kLeastGain * whole_);
      std::vector<Candidate> candidates;
      double least = most;
      for (std::size_t i = 0; i < tools_.size() && candidates.size() < kMostTried; ++i) {
        const haptics::Tool& tool = tools_[i];
        if (used[i] || !tool.cuts || tool.turns() == by_hand) continue;
        Candidate candidate{i, 0, plan(now, tool, by_hand, /*finish=*/true)};
        haptics::TissueVolume after = state_.clone();
        carve_strokes(after, tool, candidate.strokes);
        candidate.left = left_to_do(judge_.preparation(after));
        least = std::min(least, candidate.left);
        candidates.push_back(std::move(candidate));
      }
      Candidate* best = nullptr;
      for (Candidate& c : candidates) {
        if (c.left >= most || c.left > least + kHardlyMore * (before - least)) continue;
        const double wider = best ? mean_width(tools_[c.tool]) - mean_width(tools_[best->tool]) : 1;
        if (wider > kSameWidth || (wider > -kSameWidth && c.left < best->left)) best = &c;
      }
      if (!best) return;
      used[best->tool] = true;
      const haptics::Tool& tool = tools_[best->tool];
      const bool other_finishes = least < kHardlyLess * best->left;
      const std::vector<Stroke> strokes =
          other_finishes ? plan(now, tool, by_hand, /*finish=*/false) : std::move(best->strokes);
      log::info("{}: {} strokes, from {:.2f} to {:.2f} mm³ off", tool.name, strokes.size(), before * 1e9,
                best->left * 1e9);
      carve_strokes(state_, tool, strokes);
      take(static_cast<std::uint32_t>(best->tool), !by_hand);
      follow(strokes, by_hand);
    }
  }

  /// How many instruments of the tray fill.
  std::size_t fillers() const {
    return static_cast<std::size_t>(
        std::count_if(tools_.begin(), tools_.end(), [](const haptics::Tool& t) { return t.fill != Tissue::kAir; }));
  }
  /// Puts one layer of filling into what should be full: portions where the instrument comes down lowest, with the
  /// finest instrument but `coarser`. Nothing where it stands above the contour everywhere.
  /// `over`: over the contour, where less would leave it short; what is too much is carved away again.
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
    double left = 0;  // m³
    std::vector<Stroke> strokes;
  };
  std::vector<Stroke> plan(const session::Preparation& now, const haptics::Tool& tool, bool by_hand,
                           bool finish) const {
    return plan_strokes(now, tool, std::clamp(kPass * tool.diameter, kLeastPass, kMostPass), by_hand ? 0 : kAllowance,
                        around_, finish);
  }
  void follow(const std::vector<Stroke>& strokes, bool by_hand) {
    for (std::size_t i = 0; i < strokes.size(); ++i) {
      const Stroke& s = strokes[i];
      const double gap = legs_.empty() ? 1 : glm::length(s.from.p - legs_.back().to.p);
      if (gap > kJoined) go_over(s.from);
      if (gap > kNoGap) add(by_hand ? ExpertLeg::Kind::kMove : ExpertLeg::Kind::kCut, s.from);
      add(by_hand ? ExpertLeg::Kind::kScrape : ExpertLeg::Kind::kCut, s.to);
      if (s.goes_on && i + 1 < strokes.size()) legs_.back().end_pace = pace_over(s, strokes[i + 1]);
    }
    lift();
  }
  /// m/s from one stroke into the next.
  static double pace_over(const Stroke& s, const Stroke& next) {
    const dvec3 a = s.to.p - s.from.p, b = next.to.p - next.from.p;
    const double length = glm::length(a) * glm::length(b), cosine = length > 0 ? glm::dot(a, b) / length : 1;
    return cosine > kStraightOn ? kCutPace : cosine > kTurn ? kAsidePace : kTurnPace;
  }
  bool idle() const { return legs_.empty(); }
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
  /// Up, across at this height, and down: what was just put down lies between.
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
    if (drill) add(ExpertLeg::Kind::kWait, here, kRunUp);
  }

  /// A place for a portion: the instrument's end stands over the surface, the portion grows from the point nearest to
  /// it.
  struct Portion {
    Pose X_WT;
    dvec3 center;       // m
    double radius = 0;  // m
    double height = 0;  // m along the axis, of the center
    int enclosed = 0;   // voxels of tissue in reach about the center
  };

  void fill_with(std::uint32_t which) {
    const haptics::Tool& tool = tools_[which];
    session::Preparation layer = judge_.preparation(state_);
    const Instrument instrument(tool, axis_);
    std::vector<Portion> portions = places_for(instrument, layer);
    if (portions.empty()) return;
    // Corners first, then along the walls: what is left open there, no instrument reaches any more.
    std::stable_sort(portions.begin(), portions.end(),
                     [](const Portion& a, const Portion& b) { return a.enclosed > b.enclosed; });
    double lowest = 1e9;
    for (const Portion& portion : portions) lowest = std::min(lowest, portion.height);
    const double above = top_of(layer.frame, layer.after) + instrument.half + kHopOver;
    bool any = false;
    for (double window = kLayer * tool.fill_reach; !any && lowest + window < above;
         window *= 2) {  // higher, where below nothing is to be gained
      for (const Portion& first : portions) {
        if (first.height > lowest + window) continue;
        // Once more: what was just put down is in the way.
        const std::optional<Portion> portion =
            place_at(instrument, layer, glm::dot(first.X_WT.p, instrument.u), glm::dot(first.X_WT.p, instrument.v));
        if (!portion || portion->height > lowest + window) continue;
        const haptics::Fill dome(tool, portion->center, portion->radius, portion->X_WT, layer.frame);
        const double volume = put(dome, layer);
        state_.fill(haptics::Fill(tool, portion->center, portion->radius, portion->X_WT, state_.frame()));
        if (!any) take(which, false);
        any = true;
        hop(portion->X_WT, above);
        pedal_ = 1;
        add(ExpertLeg::Kind::kWait, portion->X_WT, kMostFilling, volume);
        pedal_ = 0;
      }
    }
    if (any) lift();
  }

  /// The dome into the layer; m³ that came.
  static double put(const haptics::Fill& dome, session::Preparation& layer) {
    const glm::ivec3 from = glm::max(dome.lo(), glm::ivec3(0)), to = glm::min(dome.hi(), layer.after.size - 1);
    if (glm::any(glm::lessThan(to, from))) return 0;
    const std::size_t at = layer.after.at(from.x, from.y, from.z), row = static_cast<std::size_t>(layer.after.size.z);
    PerTissue added{};
    dome.lower(from, to - from + 1, &layer.after.distance[at], &layer.tissue[at],
               row * static_cast<std::size_t>(layer.after.size.y), row, &added);
    return std::accumulate(added.begin(), added.end(), 0.0) * std::pow(layer.frame.voxel, 3);
  }

  /// A tool that fills, held upright.
  struct Instrument {
    const haptics::Tool& tool;
    dquat R_WT;
    dvec3 u, v, w;             // its axes in W
    double half;               // m from the head's middle to its free end
    std::vector<dvec3> head;   // m, its surface in W, about its middle
    haptics::HeadField field;  // m
    Instrument(const haptics::Tool& t, const dvec3& axis)
        : tool(t),
          R_WT(toward(axis)),
          u(R_WT * dvec3(1, 0, 0)),
          v(R_WT * dvec3(0, 1, 0)),
          w(R_WT * dvec3(0, 0, 1)),
          half(t.half()),
          field(t, 1) {
      for (const haptics::HeadSample& sample : haptics::sample_head(t, kHeadPoints)) head.push_back(R_WT * sample.p_TQ);
    }
  };

  /// Where a portion would bring something that is wanted.
  std::vector<Portion> places_for(const Instrument& instrument, const session::Preparation& layer) const {
    glm::dvec2 lo(1e9), hi(-1e9);
    for (int x = 0; x < layer.after.size.x; ++x) {
      for (int y = 0; y < layer.after.size.y; ++y) {
        for (int z = 0; z < layer.after.size.z; ++z) {
          if (!to_fill(layer, layer.after.at(x, y, z))) continue;
          const dvec3 p = layer.frame.to_world(dvec3(x, y, z));
          const glm::dvec2 q(glm::dot(p, instrument.u), glm::dot(p, instrument.v));
          lo = glm::min(lo, q), hi = glm::max(hi, q);
        }
      }
    }
    const double edge = 0.5 * instrument.tool.fill_reach;
    std::vector<Portion> portions;
    for (double b = lo.y - edge; b <= hi.y + edge; b += kFillGrid) {
      for (double a = lo.x - edge; a <= hi.x + edge; a += kFillGrid) {
        if (const auto portion = place_at(instrument, layer, a, b)) portions.push_back(*portion);
      }
    }
    return portions;
  }

  /// Down at this place until the instrument stands on something, and up again by what a portion is to be high.
  std::optional<Portion> place_at(const Instrument& instrument, const session::Preparation& layer, double a,
                                  double b) const {
    const double half = instrument.half, reach = instrument.tool.fill_reach, h = layer.frame.voxel;
    const auto at = [&](double c) { return a * instrument.u + b * instrument.v + c * instrument.w; };
    const auto end = [&](double c) { return layer.frame.to_voxels(at(c - half)); };
    const auto clear = [&](double c) {
      return std::all_of(instrument.head.begin(), instrument.head.end(),
                         [&](const dvec3& p) { return layer.after.sample(layer.frame.to_voxels(at(c) + p)) > kFree; });
    };
    const dvec3 size = dvec3(layer.after.size - 1) * h;
    const double middle = glm::dot(layer.frame.to_world(dvec3(layer.after.size - 1) * 0.5), instrument.w),
                 span = 0.5 * glm::length(size);
    double c = middle + span + half;
    while (c > middle - span && clear(c - kDown)) c -= kDown;
    // Up against the wall beside it: a slit between the two would stay open.
    dvec3 aside = layer.after.gradient(end(c + reach));
    aside -= glm::dot(aside, instrument.w) * instrument.w;
    if (layer.after.sample(end(c + reach)) * h < instrument.tool.radius() + kNearWall &&
        glm::length(aside) > kOneSurface) {
      const dvec3 step = kNudge * glm::normalize(aside);
      for (double moved = 0; moved < kNearWall; moved += kNudge) {
        a -= glm::dot(step, instrument.u), b -= glm::dot(step, instrument.v);
        if (clear(c)) continue;
        a += glm::dot(step, instrument.u), b += glm::dot(step, instrument.v);
        break;
      }
    }
    const auto below = [&] {  // m to what lies below the end
      double way = 0;
      while (way < reach && layer.after.sample(end(c - way)) > 0) way += kDown;
      return way;
    };
    const double height = std::min(kPortionHeight * reach, kBelowWall * instrument.tool.radius());
    for (const double from = c; below() < height && c < from + height; c += 0.5 * kDown) {
      if (layer.ideal.sample(end(c)) * h > (over_ ? kOverfill : kProud)) break;
    }
    const double gap = layer.after.sample(end(c)) * h;
    if (gap <= 0 || gap > reach) return std::nullopt;
    // As the servo finds it: the nearest surface, or midway between walls what lies below.
    dvec3 center = at(c - half);
    const dvec3 g = layer.after.gradient(end(c));
    if (glm::length(g) >= kOneSurface) {
      center -= gap * glm::normalize(g);
    } else {
      const double way = below();
      if (way >= reach) return std::nullopt;
      center -= way * instrument.w;
    }
    Portion portion{{at(c), instrument.R_WT}, center, 0, glm::dot(center, instrument.w), 0};
    return measure_portion(layer, instrument, portion) ? std::optional(portion) : std::nullopt;
  }

  /// How large a portion there brings most of what should be full and is not, for the least that is to be carved away
  /// again; false where it would not be worth it.
  bool measure_portion(const session::Preparation& in, const Instrument& instrument, Portion& portion) const {
    const dvec3 c = in.frame.to_voxels(portion.center);
    const double most = kPortionRadius * instrument.tool.fill_reach / in.frame.voxel;
    const dquat R_TW = glm::conjugate(instrument.R_WT);
    const glm::ivec3 lo = glm::max(glm::ivec3(glm::ceil(c - most)), glm::ivec3(0)),
                     hi = glm::min(glm::ivec3(glm::floor(c + most)), in.after.size - 1);
    std::vector<int> wanted(static_cast<std::size_t>(most) + 1),
        excess(wanted.size());  // voxels, by their distance from the center
    for (int x = lo.x; x <= hi.x; ++x) {
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int z = lo.z; z <= hi.z; ++z) {
          const dvec3 p(x, y, z);
          const double away = glm::length(p - c);
          const std::size_t i = in.after.at(x, y, z);
          if (away > most) continue;
          if (in.after.distance[i] <= 0) {
            ++portion.enclosed;
            continue;
          }
          if (instrument.field.distance(R_TW * (in.frame.to_world(p) - portion.X_WT.p)) <= kHeadFree * in.frame.voxel)
            continue;
          ++(to_fill(in, i) ? wanted : excess)[static_cast<std::size_t>(away)];
        }
      }
    }
    double gain = 0, best = 0, sum = 0;
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      sum += wanted[k];
      gain += wanted[k] - (over_ ? kOverfilled : kCarvedAgain) * excess[k];
      if (gain <= best || sum * std::pow(in.frame.voxel, 3) < (over_ ? kWorthOverfill : kWorthPortion)) continue;
      best = gain;
      portion.radius = std::min(static_cast<double>(k + 1), most) * in.frame.voxel;
    }
    return portion.radius > 0;
  }

  /// Empty, and to be filled: not what only lies outside the tooth.
  static bool to_fill(const session::Preparation& in, std::size_t i) {
    return in.after.distance[i] > 0 && in.ideal.distance[i] < 0 && in.ideal.distance[i] < in.before.distance[i] - 0.2f;
  }

  /// m along the axis, of the highest tissue.
  double top_of(const VoxelFrame& frame, const session::DenseField& field) const {
    double top = -1e9;
    for (int x = 0; x < field.size.x; ++x) {
      for (int y = 0; y < field.size.y; ++y) {
        for (int z = 0; z < field.size.z; ++z) {
          if (field.distance[field.at(x, y, z)] < 0)
            top = std::max(top, glm::dot(frame.to_world(dvec3(x, y, z)), axis_));
        }
      }
    }
    return top;
  }

  double whole_;  // m³
  const SurroundingsShape* around_;
  std::span<const haptics::Tool> tools_;
  const TaskJudge& judge_;
  haptics::TissueVolume state_;
  dvec3 axis_;
  double top_ = -1e9, above_ = -1e9;  // m along the axis
  std::vector<ExpertLeg> legs_;
  double pedal_ = 0;
  std::uint32_t tool_ = 0;
  bool over_ = false;  // it fills over the contour
};

}  // namespace

Expert::Expert(const Scene& scene, const haptics::TissueVolume& start)
    : scene_(scene), judge_(scene, start), around_(surroundings_shape(scene.surroundings)), whole_(0) {
  if (!judge_.has_ideal()) {
    throw Error(scene.file.string(), "\"task\"", "no \"ideal\"", "a task that says how it should be left");
  }
  whole_ = left_to_do(judge_.preparation(start));
}

std::vector<ExpertLeg> Expert::plan(const haptics::TissueVolume& now) {
  Plan plan(scene_, now, judge_, around_ ? &*around_ : nullptr, whole_);
  // What the finest instrument leaves open under its own filling, one that reaches farther gets at.
  const double missing = missing_in(judge_.preparation(now));
  vain_ = missing > missing_ - kLeastLayer ? vain_ + 1 : 0;
  missing_ = std::min(missing_, missing);
  if (vain_ > kMostVain) vain_ = 0, ++instrument_;
  if (cuts_ == 0) {
    while (plan.idle() && instrument_ < 2 * plan.fillers()) {
      plan.fill(instrument_ % plan.fillers(), /*over=*/instrument_ >= plan.fillers());
      if (plan.idle()) ++instrument_;
    }
  }
  std::vector<ExpertLeg> legs = plan.take_legs();
  const double off = left_to_do(judge_.preparation(now));
  if (!legs.empty()) {
    ++layers_;
  } else if (cuts_ < kMostCuts && (cuts_ == 0 || off < kWorthCutting * off_)) {
    if (layers_ > 0 && cuts_ == 0)
      log::info("filled in {} layers: {:.2f} mm³ missing, {:.2f} mm³ too much", layers_, missing * 1e9,
                (off - missing) * 1e9);
    plan.cut(/*by_hand=*/false);
    plan.cut(/*by_hand=*/true);
    legs = plan.take_legs();
    if (!legs.empty()) ++cuts_;
    off_ = off;
  }
  planned_ = plan.take_state();
  if (legs.empty() && layers_ + cuts_ == 0) {
    throw Error(scene_.file.string(), "\"tools\"", "no tool that brings the tissue nearer to the task's ideal",
                "one that cuts or fills there");
  }
  return legs;
}

void run_expert(HapticLoop& loop, ExpertHand& hand, Expert& expert,
                const std::function<void(const ServoTick&, const Cut*)>& each) {
  while (true) {
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
  way_ = way_out_.size();
  along_ = waited_ = worst_ = 0;
  times_ = 0;
}

haptics::DeviceInfo ExpertHand::info_for(double rate) {
  haptics::DeviceInfo info;
  info.address = "expert:";
  info.model = "a hand that knows the task";
  info.rate = rate;
  info.force_limit = info.torque_limit = 1e9;  // it bears whatever the servo gives
  return info;
}

ExpertHand::ExpertHand(std::vector<ExpertLeg> legs, double rate)
    : info_(info_for(rate)),
      legs_(std::move(legs)),
      dt_(1 / rate),
      from_(legs_.front().to),
      free_(from_),
      most_lead_(kWorkingForce * 1e-3) {
  seen_.X_WG = seen_.X_WT = from_;
}

void ExpertHand::next_leg() noexcept {
  const bool out = way_ < way_out_.size();
  const ExpertLeg& leg = out ? way_out_[way_] : legs_[leg_];
  from_ = leg.to;
  if (leg.kind == ExpertLeg::Kind::kMove) free_ = leg.to;
  ++(out ? way_ : leg_);
  along_ = waited_ = worst_ = 0;
  times_ = 0;
}

void ExpertHand::leave() noexcept {
  const ExpertLeg& left = legs_[leg_];
  const dvec3 shank = left.to.R * dvec3(0, 0, 1);
  const auto over = [&](Pose pose) {
    pose.p += std::max(0.0, glm::dot(free_.p - pose.p, shank)) * shank;
    return pose;
  };
  way_out_.fill(left);
  for (ExpertLeg& leg : way_out_) leg.kind = ExpertLeg::Kind::kMove;
  way_out_[0].to = over({seen_.X_WG.p, left.to.R});
  way_out_[1].to = over(legs_[std::min(leg_ + 1, legs_.size() - 1)].to);
  next_leg();
  from_ = {seen_.X_WG.p, left.to.R};
  way_ = 0;
}

bool ExpertHand::read(haptics::HandSample& sample) noexcept {
  if (leg_ >= legs_.size() && way_ >= way_out_.size()) return false;
  using Kind = ExpertLeg::Kind;
  const ExpertLeg leg = way_ < way_out_.size() ? way_out_[way_] : legs_[leg_];
  const bool back = leg.kind == Kind::kScrape && times_ % 2 == 1;
  const Pose &a = back ? leg.to : from_, &b = back ? from_ : leg.to;
  const double length = glm::length(b.p - a.p);
  const auto place = [&] { return length > 0 ? a.p + (along_ / length) * (b.p - a.p) : b.p; };
  const dvec3 away = place() - seen_.X_WG.p, way = length > 0 ? (b.p - a.p) / length : dvec3(0);
  const double off = glm::length(away), beside = glm::length(away - glm::dot(away, way) * way);
  waited_ += dt_;
  bool done = false, stuck = false;
  if (leg.kind == Kind::kWait) {
    along_ = length;
    const double now = -std::accumulate(seen_.removed.begin(), seen_.removed.end(), 0.0);
    if (waited_ < 1.5 * dt_) filled_ = now;
    done = waited_ >= leg.seconds || (leg.volume > 0 && now - filled_ >= leg.volume);
  } else if (leg.kind == Kind::kTake) {
    along_ = length;
    done = seen_.tool == leg.tool || waited_ > 10;
  } else {
    const double pace = leg.kind == Kind::kMove ? kTravel
                        : leg.kind == Kind::kCut
                            ? std::min(kCutPace, std::max(leg.end_pace, kEndPace) + (length - along_) / kSlowing)
                            : kScrapePace;
    const bool may = leg.kind != Kind::kCut || (off < kAhead && beside < kBeside);
    if (may && along_ < length) {
      along_ = std::min(length, along_ + pace * dt_);
      waited_ = 0;
    }
    if (leg.kind == Kind::kScrape) worst_ = std::max(worst_, off);
    done = along_ >= length && (leg.kind != Kind::kCut || off < (leg.end_pace > 0 ? kBeside : kThere));
    stuck = !done && waited_ > kPatience;
    done = done || stuck;
    if (done && leg.kind == Kind::kScrape && worst_ > kNearLine && ++times_ < kMostTimes) {
      done = false;
      along_ = length - along_;
      if (along_ >= length) along_ = 0;
      worst_ = waited_ = 0;
    }
  }
  const bool presses = leg.kind == Kind::kCut || leg.kind == Kind::kScrape;
  const bool scrapes = leg.kind == Kind::kScrape;
  dvec3 wanted =
      presses ? (scrapes ? kScrapeGain : std::min(kGain, kSteadyGain * kReactionTime / dt_)) * (place() - seen_.X_WG.p)
              : dvec3(0);
  const double size = glm::length(wanted), most = scrapes ? kMostScrapeLead : most_lead_;
  if (size > most) {
    wanted *= most / size;
    // Soft tissue gives way under the same lead: more of it, until the force is right.
    if (!scrapes)
      most_lead_ = std::clamp(most_lead_ + dt_ * kLeadPerForce * (kWorkingForce - glm::length(seen_.f_T_W)),
                              kLeastMostLead, kMostLead);
  }
  lead_ += std::min(1.0, dt_ / kReactionTime) * (wanted - lead_);
  const double share = length > 0 ? along_ / length : 1;
  sample.t = from_seconds(static_cast<double>(ticks_++) * dt_);
  sample.X_WT = {place() + lead_, glm::slerp(a.R, b.R, share)};
  sample.pedal = leg.pedal;
  sample.tool = leg.tool;
  if (done && stuck && leg.kind == Kind::kCut)
    leave();
  else if (done)
    next_leg();
  return true;
}

namespace {

/// Keeps what a hand did.
class NotedHand final : public haptics::HapticDevice {
 public:
  NotedHand(ExpertHand& hand, haptics::HandPath& path) : hand_(hand), path_(path) {}
  const haptics::DeviceInfo& info() const noexcept override { return hand_.info(); }
  bool read(haptics::HandSample& sample) noexcept override {
    if (!hand_.read(sample)) return false;
    path_.rows.push_back({to_seconds(sample.t), sample.X_WT, sample.pedal, dvec3(0), sample.tool});
    return true;
  }
  void write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept override { hand_.write(f_T_W, tau_T_W); }

 private:
  ExpertHand& hand_;
  haptics::HandPath& path_;
};

}  // namespace

std::unique_ptr<haptics::HapticDevice> open_expert_hand(const Scene& scene, double rate) {
  if (scene.implant) return open_implant_expert_hand(scene, rate);
  HapticLoop loop(scene, load_tissue(scene), rate);
  Expert expert(scene, load_untouched(scene));
  ExpertHand hand(expert.plan(loop.carver().volume()), rate);
  haptics::HandPath path;
  NotedHand noted(hand, path);
  Progress progress("expert");
  for (std::vector<ExpertLeg> rest; true; hand.go_on(std::move(rest))) {
    loop.run(noted, [&](const ServoTick& tick, const Cut*) {
      hand.see(tick);
      if (tick.index % 256 == 0) progress.at(hand.done());
    });
    rest = expert.plan(loop.carver().volume());
    if (rest.empty()) break;
  }
  return haptics::make_scripted_hand(std::move(path), rate, /*paced=*/true);
}

}  // namespace typodont
