#include "engine/app/planning/scan_review.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/units.h"

namespace typodont {

namespace {

constexpr double kMinRegion = 3e-3;  // m, smallest width of the imported region per axis
// The widest view is wider than the scan by this factor, so that a margin remains.
constexpr double kViewMargin = 1.06;
constexpr double kMinWidth = 10e-3;  // m, smallest width of the part that a section shows
// Number of samples for a preview in about a second.
constexpr double kCoarseSamples = 4e5;
// Largest stored distance in a preview, voxels. It can be small, because a preview needs only labels.
constexpr double kCoarseBand = 2;
constexpr double kTooth = 30e-3;                // m; a region longer than this contains more than a single tooth
constexpr std::array<int, 3> kNormal{2, 1, 0};  // for each section, the axis that is perpendicular to it

}  // namespace

glm::dvec3 label_color(Tissue tissue) {
  // In the order of Tissue.
  static constexpr std::array<glm::dvec3, kTissueCount> kColors{{{0, 0, 0},
                                                                 {90, 190, 255},
                                                                 {255, 205, 70},
                                                                 {150, 95, 40},
                                                                 {240, 60, 80},
                                                                 {120, 230, 140},
                                                                 {50, 150, 95},
                                                                 {255, 140, 190},
                                                                 {190, 110, 255},
                                                                 {205, 205, 225}}};
  return kColors[static_cast<std::size_t>(tissue)];
}

ScanReview::ScanReview(std::shared_ptr<const haptics::ScanVolume> scan)
    : scan_(std::move(scan)), region_{scan_->lo(), scan_->hi()} {
  crosshair_ = centre_ = 0.5 * (region_.lo + region_.hi);
  const dvec3 size = region_.hi - region_.lo;
  const double longest = std::max({size.x, size.y, size.z});
  whole_ = width_ = kViewMargin * longest;
  preset_ = longest > kTooth ? haptics::ImportPreset::kJaw : haptics::ImportPreset::kTooth;
}

void ScanReview::look_at(const dvec3& p_F) {
  crosshair_ = glm::clamp(p_F, scan_->lo(), scan_->hi());
  ++changes_;
}

void ScanReview::scroll(std::size_t section, int slices) {
  dvec3 p = crosshair_;
  const int axis = kNormal.at(section);
  p[axis] += slices * scan_->spacing()[axis];
  look_at(p);
}

void ScanReview::set_width(double width) {
  width_ = std::clamp(width, std::min(kMinWidth, whole_), whole_);
  centre_ = width_ < whole_ ? crosshair_ : 0.5 * (scan_->lo() + scan_->hi());
  ++changes_;
}

ScanPlanes ScanReview::planes() const {
  // The observer faces the patient; the head points up.
  const double to_left = scan_->space() == "RAS" ? -1 : 1, to_back = to_left;
  const dvec3 left(to_left, 0, 0), back(0, to_back, 0), head(0, 0, 1);
  const auto plane = [&](std::size_t section, const dvec3& right, const dvec3& up) {
    dvec3 centre = centre_;
    centre[kNormal[section]] = crosshair_[kNormal[section]];
    return SectionPlane{centre, right, up, width_, width_};
  };
  return {plane(0, left, -back), plane(1, left, head), plane(2, back, head)};
}

std::array<std::string_view, 2> ScanReview::sides(std::size_t section) const {
  if (scan_->space().empty()) return {"", ""};
  if (section == 2) return {"A", "P"};
  return {"R", "L"};
}

void ScanReview::set_region(const haptics::ImportRegion& region) {
  const dvec3 lo = scan_->lo(), hi = scan_->hi(), least = glm::min(dvec3(kMinRegion), hi - lo);
  region_.lo = glm::clamp(region.lo, lo, hi - least);
  region_.hi = glm::clamp(glm::max(region.hi, region_.lo + least), lo, hi);
  given_up_ = LabelDetail::kNone;
  full_wanted_ = false;
  ++revision_;
  ++changes_;
}

glm::ivec3 ScanReview::walls_at(std::size_t section, const dvec3& p_F, double reach) const {
  glm::ivec3 walls(0);
  for (int a = 0; a < 3; ++a) {
    if (a == kNormal.at(section)) continue;
    const int b = 3 - a - kNormal[section];  // index of the second axis in the section's plane
    if (p_F[b] < region_.lo[b] - reach || p_F[b] > region_.hi[b] + reach) continue;
    const double from_lo = std::abs(p_F[a] - region_.lo[a]), from_hi = std::abs(p_F[a] - region_.hi[a]);
    if (std::min(from_lo, from_hi) <= reach) walls[a] = from_lo < from_hi ? -1 : 1;
  }
  return walls;
}

void ScanReview::move_walls(const glm::ivec3& walls, const dvec3& p_F) {
  haptics::ImportRegion moved = region_;
  for (int a = 0; a < 3; ++a) {
    if (walls[a] < 0) moved.lo[a] = std::min(p_F[a], region_.hi[a] - kMinRegion);
    if (walls[a] > 0) moved.hi[a] = std::max(p_F[a], region_.lo[a] + kMinRegion);
  }
  set_region(moved);
}

void ScanReview::set_dragging(bool dragging) {
  if (dragging_ && !dragging) full_wanted_ = true;
  dragging_ = dragging;
}

void ScanReview::set_preset(haptics::ImportPreset preset) {
  if (preset == preset_) return;
  preset_ = preset;
  given_up_ = LabelDetail::kNone;
  full_wanted_ = false;
  ++revision_;
  ++changes_;
}

haptics::ImportOptions ScanReview::options() const {
  haptics::ImportOptions options;
  options.preset = preset_;
  options.region = region_;
  return options;
}

std::optional<LabelRequest> ScanReview::request() const {
  const LabelDetail known = current() ? detail_ : LabelDetail::kNone;
  LabelRequest wanted{LabelDetail::kNone, revision_, options()};
  if (known == LabelDetail::kNone && given_up_ == LabelDetail::kNone) {
    wanted.detail = LabelDetail::kCoarse;
    const dvec3 size = region_.hi - region_.lo, spacing = scan_->spacing();
    const double finest = std::min({spacing.x, spacing.y, spacing.z});
    const double times = std::cbrt(size.x * size.y * size.z / kCoarseSamples) / finest;
    wanted.options.voxel = finest * std::max(1.0, std::ceil(times));
    wanted.options.band = kCoarseBand * *wanted.options.voxel;
    wanted.options.greys = false;
    return wanted;
  }
  if (full_wanted_ && !dragging_ && known != LabelDetail::kFull) {
    wanted.detail = LabelDetail::kFull;
    return wanted;
  }
  return std::nullopt;
}

void ScanReview::take(const LabelRequest& request, haptics::Imported labels) {
  const bool of_now = request.revision == revision_;
  if (!of_now && (request.detail == LabelDetail::kFull || (current() && detail_ == LabelDetail::kFull))) return;
  labels_ = std::move(labels);
  detail_ = request.detail;
  labels_revision_ = request.revision;
  volumes_ = labels_.report.volume;
  ++changes_;
  if (detail_ != LabelDetail::kFull) return;
  // Removes undone corrections, which belong to the old labels.
  steps_.resize(done_);
  for (Step& step : steps_) {
    const std::vector<haptics::Correction> again = std::exchange(step, {}).corrections;
    for (const haptics::Correction& correction : again) apply(step, correction);
  }
  // A replacement of the whole tissue cannot be repeated on new labels, so its step is removed.
  std::erase_if(steps_, [](const Step& step) { return step.corrections.empty(); });
  done_ = steps_.size();
}

void ScanReview::give_up(const LabelRequest& request) {
  if (request.revision != revision_) return;
  if (request.detail == LabelDetail::kFull)
    full_wanted_ = false;  // full labels are computed again only when the user requests them
  else
    given_up_ = LabelDetail::kCoarse;
}

void ScanReview::apply(Step& step, const haptics::Correction& correction) {
  haptics::BoxContent before = haptics::correct(labels_, correction);
  const PerTissue was = haptics::volumes_in(before, labels_.tissue.frame.voxel),
                  is = haptics::volumes_in(labels_.tissue, before.box);
  for (std::size_t t = 0; t < volumes_.size(); ++t) volumes_[t] += is[t] - was[t];
  step.corrections.push_back(correction);
  step.before.push_back(std::move(before));
  ++changes_;
}

void ScanReview::correct(const haptics::Correction& correction, bool joins) {
  if (!can_correct()) return;
  if (!joins || done_ == 0) {
    steps_.resize(done_);
    steps_.emplace_back();
    ++done_;
  }
  apply(steps_[done_ - 1], correction);
}

void ScanReview::replace(haptics::DenseTissue tissue) {
  if (!can_correct() || tissue.size != labels_.tissue.size) return;
  const haptics::VoxelBox all{glm::ivec3(0), tissue.size - 1};
  Step step;
  step.before.push_back({all, std::move(tissue.distance), std::move(tissue.tissue), std::move(tissue.hardness)});
  steps_.resize(done_);
  exchange(step.before.front());
  steps_.push_back(std::move(step));
  ++done_;
}

void ScanReview::exchange(haptics::BoxContent& content) {
  const PerTissue is = haptics::volumes_in(content, labels_.tissue.frame.voxel),
                  was = haptics::volumes_in(labels_.tissue, content.box);
  for (std::size_t t = 0; t < volumes_.size(); ++t) volumes_[t] += is[t] - was[t];
  haptics::exchange(labels_, content);
  ++changes_;
}

void ScanReview::undo() {
  if (!can_undo()) return;
  Step& step = steps_[--done_];
  for (std::size_t i = step.before.size(); i-- > 0;) exchange(step.before[i]);
}

void ScanReview::redo() {
  if (!can_redo()) return;
  for (haptics::BoxContent& content : steps_[done_++].before) exchange(content);
}

std::vector<haptics::Correction> ScanReview::corrections() const {
  std::vector<haptics::Correction> all;
  for (std::size_t i = 0; i < done_; ++i)
    all.insert(all.end(), steps_[i].corrections.begin(), steps_[i].corrections.end());
  return all;
}

render::Picture ScanReview::picture(const SectionPlane& plane, int pixels) const {
  // kTint: weight of the label's colour in the picture. kOutside: factor on the brightness outside of the region.
  constexpr double kTint = 0.45, kOutside = 0.45;
  const dvec3 lo = scan_->lo() - 0.5 * scan_->spacing(), hi = scan_->hi() + 0.5 * scan_->spacing();
  const double black = scan_->black(), white = scan_->white();
  const auto within = [](const dvec3& p, const dvec3& a, const dvec3& b) {
    return glm::all(glm::greaterThanEqual(p, a)) && glm::all(glm::lessThanEqual(p, b));
  };
  const haptics::DenseTissue* t = labels() ? &labels_.tissue : nullptr;
  render::Picture picture{{pixels, pixels}, {}};
  picture.rgba.reserve(4 * static_cast<std::size_t>(pixels) * static_cast<std::size_t>(pixels));
  for (int y = 0; y < pixels; ++y) {
    for (int x = 0; x < pixels; ++x) {
      const dvec3 p = plane.at((dvec2(x, y) + 0.5) / static_cast<double>(pixels));
      dvec3 color(24);
      if (within(p, lo, hi)) {
        color = dvec3(24 + 231 * std::clamp((scan_->grey(p) - black) / (white - black), 0.0, 1.0));
        if (!within(p, region_.lo, region_.hi)) {
          color *= kOutside;
        } else if (t) {
          const glm::ivec3 i(glm::round(t->frame.to_voxels(p)));
          if (glm::all(glm::greaterThanEqual(i, glm::ivec3(0))) && glm::all(glm::lessThan(i, t->size))) {
            const std::size_t at = t->at(i.x, i.y, i.z);
            if (t->distance[at] < 0) color = glm::mix(color, label_color(t->tissue[at]), kTint);
          }
        }
      }
      for (int c = 0; c < 3; ++c) picture.rgba.push_back(static_cast<std::uint8_t>(std::lround(color[c])));
      picture.rgba.push_back(255);
    }
  }
  return picture;
}

}  // namespace typodont
