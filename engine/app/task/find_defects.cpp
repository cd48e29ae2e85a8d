#include "engine/app/task/find_defects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <tuple>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/tool.h"

namespace typodont {

namespace {

using session::Defect;
using session::DefectStroke;
using session::Preparation;

constexpr double kMinDepth = 0.15e-3;  // m, smallest deviation from the ideal shape that is a defect
// Smallest volume of pulp, protected tissue or caries that is a defect: in m³, and as a fraction of the rule's
// tolerance.
constexpr double kMinVolume = 0.005e-9, kMinTolerated = 0.05;
constexpr double kMinFraction = 0.1;  // a stroke that cut a smaller fraction of a defect's volume is not listed
constexpr double kClosest = 1e-3;     // m, remaining tissue is attributed only to a cut at most this far away
constexpr double kMaxLoss = 1.0 / 3;  // a score item that lost a smaller fraction of its points has no defect
constexpr std::size_t kMaxDefects = 24, kMaxStrokes = 4;
constexpr double kBefore = 1.0, kAfter = 0.5;  // s, the tool's path is stored for so long before and after a stroke
constexpr std::size_t kPathMoments = 60;

enum class Kind : std::uint8_t { kNone, kOver, kUnder, kPulp, kProtected, kCaries };
constexpr const char* kItems[] = {
    "", "over_cut_depth_mm", "under_cut_depth_mm", "pulp_removed_mm3", "protected_removed_mm3", "residual_caries_mm3"};
constexpr std::size_t kDefectKinds = std::size(kItems);

/// True: the kind's amount is a depth, m; false: a volume, m³.
bool by_depth(Kind kind) {
  return kind == Kind::kOver || kind == Kind::kUnder;
}

/// The tools' heads at the recorded cuts.
class Cutters {
 public:
  Cutters(std::span<const Cut* const> cuts, std::span<const haptics::Tool> tools) : cuts_(cuts), tools_(tools) {
    for (const haptics::Tool& tool : tools) fields_.emplace_back(tool, 1);
  }
  std::span<const Cut* const> cuts() const { return cuts_; }
  const haptics::Tool& tool(std::uint32_t tool) const { return tools_[std::min<std::size_t>(tool, tools_.size() - 1)]; }
  double reach(const Cut& cut) const { return cut.fill_radius > 0 ? cut.fill_radius : tool(cut.tool).reach(); }
  /// Distance (m) of p_W from the cutting head at the fraction s of its path from A to B; for a filling, from its ball.
  double distance(const Cut& cut, double s, const dvec3& p_W) const {
    if (cut.fill_radius > 0) return glm::length(p_W - cut.X_WA.p) - cut.fill_radius;
    const Pose& X_WT = s < 1 ? cut.X_WA : cut.X_WB;
    const dvec3 from = glm::mix(cut.X_WA.p, cut.X_WB.p, s);
    return fields_[std::min<std::size_t>(cut.tool, fields_.size() - 1)].distance(glm::transpose(glm::dmat3(X_WT.R)) *
                                                                                 (p_W - from));
  }
  /// The cut whose head came closest to p_W; null if no head came within kClosest.
  const Cut* closest(const dvec3& p_W) const {
    const Cut* best = nullptr;
    double nearest = kClosest;
    for (const Cut* cut : cuts_) {
      if (glm::length(p_W - cut->X_WB.p) - reach(*cut) >= nearest) continue;
      if (const double d = distance(*cut, 1, p_W); d < nearest) nearest = d, best = cut;
    }
    return best;
  }

 private:
  std::span<const Cut* const> cuts_;
  std::span<const haptics::Tool> tools_;
  std::vector<haptics::HeadField> fields_;
};

/// For each voxel near a defect: the cut that last removed or filled it.
class Makers {
 public:
  explicit Makers(const Preparation& in) : in_(in), size_((in.before.size + kBlock - 1) / kBlock) {
    blocks_.resize(voxel_count(size_));
  }
  void want(const glm::ivec3& v) {
    const std::size_t i = in_.before.at(v.x, v.y, v.z);
    const auto [it, fresh] = index_.try_emplace(i, points_.size());
    if (!fresh) return;
    blocks_[voxel_index(v / kBlock, size_)].push_back(points_.size());
    points_.push_back({in_.frame.to_world(dvec3(v)), in_.before.distance[i] < 0, nullptr});
  }
  void replay(const Cutters& cutters) {
    for (const Cut* cut : cutters.cuts()) apply(cutters, *cut);
  }
  const Cut* of(std::size_t voxel) const {
    const auto it = index_.find(voxel);
    return it == index_.end() ? nullptr : points_[it->second].by;
  }

 private:
  static constexpr int kBlock = 8;
  struct Point {
    dvec3 p_W;
    bool solid;
    const Cut* by;
  };
  void apply(const Cutters& cutters, const Cut& cut) {
    const double h = in_.frame.voxel, reach = cutters.reach(cut);
    const bool fills = cut.fill_radius > 0;
    const dvec3 a = in_.frame.to_voxels(cut.X_WA.p), b = fills ? a : in_.frame.to_voxels(cut.X_WB.p);
    const glm::ivec3 lo =
        glm::max(glm::ivec3(glm::floor((glm::min(a, b) - reach / h) / double(kBlock))), glm::ivec3(0));
    const glm::ivec3 hi = glm::min(glm::ivec3(glm::floor((glm::max(a, b) + reach / h) / double(kBlock))), size_ - 1);
    const int steps = std::max(1, static_cast<int>(std::ceil(glm::length(b - a) / 0.5)));
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
      for (const std::size_t i : blocks_[voxel_index({x, y, z}, size_)]) {
        Point& point = points_[i];
        if (point.solid == fills) continue;
        bool inside = false;
        for (int k = 0; k <= steps && !inside; ++k)
          inside = cutters.distance(cut, static_cast<double>(k) / steps, point.p_W) <= 0;
        if (inside) point.solid = fills, point.by = &cut;
      }
    });
  }

  const Preparation& in_;
  glm::ivec3 size_;                               // number of blocks along each axis
  std::vector<std::vector<std::size_t>> blocks_;  // indices of the points in each block
  std::vector<Point> points_;
  std::map<std::size_t, std::size_t> index_;  // key: index of a voxel; value: index of its point in points_
};

/// Connected voxels with the same kind of deviation.
struct Region {
  Kind kind = Kind::kNone;
  std::vector<std::size_t> voxels;
  std::size_t deepest = 0;  // index of the voxel with the largest deviation
  double depth = 0;         // m, largest distance from the ideal shape
};

/// For each voxel: the deviation of the result from the target shape.
class Deviations {
 public:
  /// `limits`: for each kind, the amount above which a deviation is a defect.
  Deviations(const Preparation& in, const std::array<double, kDefectKinds>& limits) : in_(in), limits_(limits) {
    const bool compares = !in.ideal.distance.empty();
    const std::size_t count = in.after.distance.size();
    kind_.resize(count, Kind::kNone);
    depth_.resize(count);
    session::TrueDistances ideal;
    if (compares) ideal = session::TrueDistances(in.ideal);
    for (std::size_t i = 0; i < count; ++i) {
      const bool was = in.before.distance[i] < 0, is = in.after.distance[i] < 0;
      const bool should = compares ? in.ideal.distance[i] < 0 : was && in.tissue[i] != Tissue::kCaries;
      if (is == should) continue;
      if (compares) depth_[i] = std::abs(ideal[i]) * static_cast<float>(in.frame.voxel);
      if (should) {
        if (was && !in.keep.empty() && in.keep[i])
          kind_[i] = Kind::kProtected;
        else if (was && in.tissue[i] == Tissue::kPulp)
          kind_[i] = Kind::kPulp;
        else if (compares && depth_[i] > 0.5 * limit(Kind::kOver))
          kind_[i] = Kind::kOver;
      } else if (!compares) {
        kind_[i] = Kind::kCaries;
      } else if (depth_[i] > 0.5 * limit(Kind::kUnder)) {
        kind_[i] = Kind::kUnder;
      }
    }
  }
  double depth(std::size_t voxel) const { return depth_[voxel]; }
  double limit(Kind kind) const { return limits_[static_cast<std::size_t>(kind)]; }
  /// Largest depth (m) or volume (m³) of a region.
  double amount(const Region& region) const {
    return by_depth(region.kind) ? region.depth : volume(region.voxels.size());
  }
  double volume(std::size_t voxels) const { return static_cast<double>(voxels) * std::pow(in_.frame.voxel, 3); }
  glm::ivec3 at(std::size_t i) const { return voxel_at(i, in_.after.size); }
  dvec3 place(std::size_t voxel) const { return in_.frame.to_world(dvec3(at(voxel))); }

  std::vector<Region> regions() {
    std::vector<Region> found;
    std::vector<std::size_t> stack;
    for (std::size_t first = 0; first < kind_.size(); ++first) {
      if (kind_[first] == Kind::kNone) continue;
      Region region{kind_[first], {}, first, depth_[first]};
      kind_[first] = Kind::kNone;
      for (stack.assign(1, first); !stack.empty();) {
        const std::size_t i = stack.back();
        stack.pop_back();
        region.voxels.push_back(i);
        if (depth_[i] > region.depth) region.depth = depth_[i], region.deepest = i;
        each_neighbour(at(i), [&](std::size_t j) {
          if (kind_[j] != region.kind) return;
          kind_[j] = Kind::kNone;
          stack.push_back(j);
        });
      }
      if (amount(region) > limit(region.kind)) found.push_back(std::move(region));
    }
    return found;
  }
  /// Calls `visit` for voxel v and its neighbours in the box, at most 27.
  template <class Visit>
  void each_neighbour(const glm::ivec3& v, const Visit& visit) const {
    const glm::ivec3 lo = glm::max(v - 1, glm::ivec3(0)), hi = glm::min(v + 1, in_.after.size - 1);
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) { visit(in_.after.at(x, y, z)); });
  }

 private:
  const Preparation& in_;
  std::array<double, kDefectKinds> limits_;
  std::vector<Kind> kind_;
  std::vector<float> depth_;  // m, each voxel's distance from the target surface
};

const session::ScoreItem* item_of(const session::Score& score, std::string_view name) {
  const auto it = std::ranges::find(score.items, name, &session::ScoreItem::name);
  return it == score.items.end() ? nullptr : &*it;
}

DefectStroke stroke_of(const Cut& cut) {
  DefectStroke stroke;
  stroke.first = stroke.last = stroke.worst = cut.tick;
  stroke.tool = cut.tool;
  return stroke;
}

/// The strokes (successive cuts) to which the voxels of a region are attributed. The amount of a stroke is its largest
/// depth, m, or its volume, m³.
std::vector<DefectStroke> strokes_of(const Region& region, const Deviations& deviations, const Makers& makers,
                                     const Cutters& cutters) {
  std::map<const Cut*, std::vector<std::size_t>,
           decltype([](const Cut* a, const Cut* b) { return a->index < b->index; })>
      by_cut;
  std::vector<std::size_t> others;
  for (const std::size_t voxel : region.voxels) {
    const Cut* cut = makers.of(voxel);
    cut ? by_cut[cut].push_back(voxel) : others.push_back(voxel);
  }
  if (by_cut.empty()) others.assign(1, region.deepest);  // no stroke changed a voxel of the region
  // Voxels that no cut changed (left tissue, loose pieces that fell off) are attributed to the closest cut.
  if (!others.empty()) {
    const auto deepest = *std::ranges::max_element(others, {}, [&](std::size_t i) { return deviations.depth(i); });
    if (const Cut* cut = cutters.closest(deviations.place(deepest)))
      by_cut[cut].insert(by_cut[cut].end(), others.begin(), others.end());
  }
  const bool deep = by_depth(region.kind);
  std::vector<DefectStroke> strokes;
  const Cut* before = nullptr;
  double worst = 0;
  for (const auto& [cut, voxels] : by_cut) {
    if (!before || cut->tool != before->tool || to_seconds(cut->t - before->t) > session::kStrokePause) {
      strokes.push_back(stroke_of(*cut));
      worst = 0;
    }
    before = cut;
    DefectStroke& stroke = strokes.back();
    stroke.last = cut->tick;
    double share = deviations.volume(voxels.size());
    if (deep) {
      share = 0;
      for (const std::size_t voxel : voxels) share = std::max(share, deviations.depth(voxel));
    }
    if (share > worst) worst = share, stroke.worst = cut->tick;
    stroke.amount = deep ? std::max(stroke.amount, share) : stroke.amount + share;
  }
  const double least = deep ? deviations.limit(region.kind) : kMinFraction * deviations.amount(region);
  std::erase_if(strokes, [&](const DefectStroke& stroke) { return stroke.amount < least; });
  return strokes;
}

/// Finds the stroke that last changed the surface at the place to which this item of the score refers.
std::optional<Defect> at_surface(const session::ScoreItem& item, const Preparation& in, const Deviations& deviations,
                                 const Makers& makers) {
  const dvec3 p = glm::clamp(glm::round(in.frame.to_voxels(*item.place_W)), dvec3(0), dvec3(in.after.size - 1));
  const Cut* last = nullptr;
  deviations.each_neighbour(glm::ivec3(p), [&](std::size_t i) {
    const Cut* cut = makers.of(i);
    if (cut && (!last || cut->index > last->index)) last = cut;
  });
  if (!last) return std::nullopt;
  Defect defect{item.name, item.value, *item.place_W};
  defect.strokes.push_back(stroke_of(*last));
  defect.strokes.back().amount = item.value;
  return defect;
}

std::vector<Defect> of_tissue(const EvaluatedSession& judged, const Cutters& cutters) {
  if (!judged.preparation) return {};
  const Preparation& in = *judged.preparation;
  std::array<double, kDefectKinds> limits{};
  for (std::size_t k = 1; k < kDefectKinds; ++k) {
    const session::ScoreItem* item = item_of(judged.score, kItems[k]);
    limits[k] = by_depth(static_cast<Kind>(k))
                    ? std::max(item ? item->target * kMillimetre : 0, kMinDepth)
                    : std::max(item ? kMinTolerated * item->tolerance * kCubicMillimetre : 0, kMinVolume);
  }
  Deviations deviations(in, limits);
  const std::vector<Region> regions = deviations.regions();
  std::vector<const session::ScoreItem*> places;
  for (const char* name : {"wall_thickness_mm", "pulp_distance_mm"}) {
    const session::ScoreItem* item = item_of(judged.score, name);
    if (item && item->place_W && item->value > 0 && item->points < (1 - kMaxLoss) * item->full) places.push_back(item);
  }
  Makers makers(in);
  for (const Region& region : regions)
    for (const std::size_t voxel : region.voxels) makers.want(deviations.at(voxel));
  for (const session::ScoreItem* item : places)
    deviations.each_neighbour(glm::ivec3(glm::round(in.frame.to_voxels(*item->place_W))), [&](std::size_t i) {
      if (in.before.distance[i] < 0 && in.after.distance[i] >= 0) makers.want(deviations.at(i));
    });
  makers.replay(cutters);

  std::vector<Defect> defects;
  for (const Region& region : regions) {
    const double unit = by_depth(region.kind) ? kMillimetre : kCubicMillimetre;
    Defect defect{kItems[int(region.kind)], deviations.amount(region) / unit, deviations.place(region.deepest)};
    defect.left = std::ranges::none_of(region.voxels, [&](std::size_t i) { return makers.of(i); });
    defect.strokes = strokes_of(region, deviations, makers, cutters);
    for (DefectStroke& stroke : defect.strokes) stroke.amount /= unit;
    defects.push_back(std::move(defect));
  }
  for (const session::ScoreItem* item : places)
    if (auto defect = at_surface(*item, in, deviations, makers)) defects.push_back(std::move(*defect));
  return defects;
}

std::vector<Defect> of_damage(const session::DamageMeasures& damage) {
  std::vector<Defect> defects;
  for (const session::DamageMeasures::Touch& touch : damage.touches) {
    Defect defect{touch.gum ? "gingiva_removed_mm3" : "neighbour_removed_mm3", touch.volume / kCubicMillimetre,
                  touch.p_W, false};
    DefectStroke stroke;
    stroke.first = touch.first, stroke.last = touch.last, stroke.worst = touch.worst;
    stroke.tool = touch.tool;
    stroke.amount = defect.amount;
    defect.strokes.push_back(stroke);
    defects.push_back(std::move(defect));
  }
  return defects;
}

/// Finds the times at which the force was larger than the score tolerates.
class ForceMeter {
 public:
  /// `max`: N, largest force that costs no points
  explicit ForceMeter(double max) : max_(max) {}
  void add(const ServoTick& tick) {
    if ((tick.faults & bits(Fault::kHeld)) || !(tick.depth > 0 || tick.contact_area > 0)) return;
    const double force = glm::length(tick.f_T_W);
    if (!(force > max_)) return;
    if (defects_.empty() || to_seconds(tick.t - last_) > session::kStrokePause) {
      defects_.push_back({"force_max_N", 0, tick.X_WG.p, false, false, {DefectStroke()}});
      defects_.back().strokes[0].first = tick.index;
    }
    last_ = tick.t;
    Defect& defect = defects_.back();
    DefectStroke& stroke = defect.strokes[0];
    stroke.last = tick.index;
    if (force <= defect.amount) return;
    defect.amount = stroke.amount = force;
    defect.p_W = tick.X_WG.p;
    stroke.worst = tick.index;
    stroke.tool = tick.tool;
  }
  std::vector<Defect> take() { return std::move(defects_); }

 private:
  double max_;
  Nanos last_ = 0;
  std::vector<Defect> defects_;
};

/// Sets the members of each stroke that come from the ticks: its times, poses and forces.
void add_moments(const session::SessionReader& session, std::span<const haptics::Tool> tools,
                 std::vector<Defect>& defects) {
  const double rate = session.header().servo_rate;
  std::vector<DefectStroke*> strokes;
  for (Defect& defect : defects)
    for (DefectStroke& stroke : defect.strokes) strokes.push_back(&stroke);
  if (strokes.empty()) return;
  std::ranges::sort(strokes, {}, &DefectStroke::first);
  const auto margin = static_cast<std::uint64_t>(kBefore * rate), after = static_cast<std::uint64_t>(kAfter * rate);
  std::size_t begin = 0;
  const auto see = [&](const ServoTick& tick) {
    for (std::size_t k = begin; k < strokes.size(); ++k) {
      DefectStroke& stroke = *strokes[k];
      if (tick.index + margin < stroke.first) break;
      if (tick.index > stroke.last + after) {
        if (k == begin) ++begin;
        continue;
      }
      const session::HeadMoment moment{to_seconds(tick.t), tick.X_WG, glm::length(tick.f_T_W)};
      if (tick.index == stroke.first) stroke.from = moment.t;
      if (tick.index == stroke.last) stroke.to = moment.t;
      if (tick.index == stroke.worst) stroke.at = moment;
      const std::uint64_t every = (stroke.last - stroke.first + margin + after) / kPathMoments + 1;
      if (tick.index % every == 0) stroke.path.push_back(moment);
    }
  };
  session.each_piece([&](const std::vector<ServoTick>& ticks) { std::ranges::for_each(ticks, see); });
  for (DefectStroke* stroke : strokes) {
    const haptics::Tool& tool = tools[std::min<std::size_t>(stroke->tool, tools.size() - 1)];
    stroke->head_radius = tool.radius(), stroke->head_half = tool.half();
  }
}

}  // namespace

std::vector<session::Defect> find_defects(const session::SessionReader& session, const EvaluatedSession& judged) {
  const std::span<const haptics::Tool> tools = haptics::tool_set(judged.scene.servo);
  const Cutters cutters(judged.cuts, tools);
  std::vector<Defect> defects = of_tissue(judged, cutters);
  if (judged.input.damage) std::ranges::move(of_damage(*judged.input.damage), std::back_inserter(defects));
  if (const session::ScoreItem* item = item_of(judged.score, "force_max_N"); item && item->full > 0) {
    ForceMeter force(item->target);
    session.each_piece([&](const std::vector<ServoTick>& ticks) {
      for (const ServoTick& tick : ticks) force.add(tick);
    });
    std::ranges::move(force.take(), std::back_inserter(defects));
  }

  // If there are too many defects, keeps the largest of each score item; sorts the kept ones by time.
  std::map<std::string, double> largest;
  for (const Defect& defect : defects) largest[defect.item] = std::max(largest[defect.item], defect.amount);
  std::ranges::stable_sort(defects, std::greater(),
                           [&](const Defect& defect) { return defect.amount / largest[defect.item]; });
  if (defects.size() > kMaxDefects) defects.resize(kMaxDefects);
  for (Defect& defect : defects) {
    if (defect.strokes.size() <= kMaxStrokes) continue;
    std::ranges::sort(defect.strokes, std::greater(), &DefectStroke::amount);
    defect.strokes.resize(kMaxStrokes);
    std::ranges::sort(defect.strokes, {}, &DefectStroke::first);
  }
  add_moments(session, tools, defects);
  std::ranges::stable_sort(defects, {}, [](const Defect& defect) {
    return defect.strokes.empty() ? UINT64_MAX : defect.strokes.front().first;
  });
  return defects;
}

}  // namespace typodont
