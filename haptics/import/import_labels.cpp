#include "haptics/import/import_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/lower_case.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/distance.h"
#include "haptics/import/import_scan.h"

namespace typodont::haptics::importing {

namespace {
// Smoothing of the labels, voxels of the map: removes the steps of a border without moving it.
constexpr double kBorderBlur = 0.7;
// Largest number of different labels.
constexpr std::size_t kMaxLabels = 256;
constexpr float kMaxLabel = 65535;

using Counts = std::map<float, std::size_t>;
}  // namespace

// Counts the voxels of at most `most` different values.
static Counts values_of(const Scan& scan, std::size_t most) {
  Counts counts;
  std::size_t* last = nullptr;
  float value = 0;
  for (const float g : scan.grey.v) {
    if (!last || g != value) {
      last = &counts[g], value = g;
      if (counts.size() > most) break;
    }
    ++*last;
  }
  return counts;
}

static std::string list_of(const Counts& counts) {
  std::string text;
  for (const auto& [value, count] : counts) text += fmt::format("{}{:g}", text.empty() ? "" : ", ", value);
  return text;
}

static std::string tissues_in_words() {
  std::string text;
  for (int t = 1; t < kTissueCount; ++t)
    text += fmt::format("{}{}", text.empty() ? "" : ", ", name_of(static_cast<Tissue>(t)));
  return text;
}

// Tissue of a segment name such as "Enamel", "Cortical bone" or "cortical-bone".
static std::optional<Tissue> tissue_of(const std::string& segment) {
  std::string name = lower_case(segment);
  std::ranges::replace_if(
      name, [](char c) { return c == ' ' || c == '-'; }, '_');
  return tissue_named(name);
}

bool is_label_map(const Scan& scan, const ImportOptions& options) {
  return scan.labels || !options.labels.empty();
}

void refuse_labels(const std::filesystem::path& file, const Scan& scan) {
  constexpr std::size_t kFew = 6;
  constexpr float kMaxGuessed = 64;
  const Counts counts = values_of(scan, kFew);
  const auto is_label = [](const auto& count) {
    return count.first == std::floor(count.first) && count.first >= 0 && count.first < kMaxGuessed;
  };
  if (scan.labels || (counts.size() > 1 && counts.size() <= kFew && std::ranges::all_of(counts, is_label))) {
    throw Error(file.string(), "greys", fmt::format("the values {} alone: a label map", list_of(counts)),
                "a scan's greys; typodont import reads a label map with --label VALUE=TISSUE for each value");
  }
}

// Tissue of each value of the label map; the value is the index; 0 is air.
static std::vector<Tissue> tissues_of(const std::filesystem::path& file, const Scan& scan, const ImportOptions& options,
                                      std::vector<std::string>& notes) {
  std::vector<Tissue> tissues{Tissue::kAir};
  const Counts counts = values_of(scan, kMaxLabels);
  if (counts.size() > kMaxLabels)
    throw Error(file.string(), "labels", fmt::format("more than {} values", kMaxLabels), "a label map");
  std::string said;
  for (const auto& [value, count] : counts) {
    if (value == 0) continue;
    if (!(value > 0 && value <= kMaxLabel && value == std::floor(value)))
      throw Error(file.string(), "labels", fmt::format("the value {:g}", value), "whole numbers, 0 for air");
    const auto label = static_cast<int>(value);
    std::string name;
    if (scan.labels && scan.labels->contains(label)) name = scan.labels->at(label);
    const auto given = options.labels.find(label);
    const std::optional<Tissue> tissue = given != options.labels.end() ? std::optional(given->second) : tissue_of(name);
    if (!tissue) {
      throw Error(
          file.string(), "labels",
          fmt::format("the value {}{} in {} voxels", label, name.empty() ? "" : fmt::format(" (\"{}\")", name), count),
          fmt::format("--label {}=TISSUE, one of air, {}", label, tissues_in_words()));
    }
    tissues.resize(std::max(tissues.size(), static_cast<std::size_t>(label) + 1), Tissue::kAir);
    tissues[static_cast<std::size_t>(label)] = *tissue;
    said += fmt::format("{}{} {}", said.empty() ? "" : ", ", label, name_of(*tissue));
  }
  for (const auto& [label, tissue] : options.labels) {
    if (!counts.contains(static_cast<float>(label)))
      throw Error("--label", "", fmt::format("{}={}", label, name_of(tissue)),
                  fmt::format("one of the values {}", list_of(counts)));
  }
  notes.push_back(fmt::format("a label map: {}; its borders were smoothed by {} voxel", said, kBorderBlur));
  return tissues;
}

Imported import_labels(const std::filesystem::path& file, const Scan& scan, const ImportOptions& options) {
  if (options.surface_grey || options.hardness || options.hounsfield)
    throw Error(file.string(), "labels", "options for grey values", "none for a label map");
  Imported result;
  ImportReport& report = result.report;
  report.format = scan.format + " label map";
  report.spacing = scan.spacing;
  report.space = scan.space;
  report.world_rotation = scan.world_rotation;
  report.notes = scan.notes;
  const std::vector<Tissue> tissues = tissues_of(file, scan, options, report.notes);
  const auto tissue_at = [&](float value) { return tissues[static_cast<std::size_t>(value)]; };

  glm::ivec3 first = scan.grey.size, last(-1);
  for (std::size_t i = 0; i < scan.grey.v.size(); ++i) {
    if (tissue_at(scan.grey.v[i]) == Tissue::kAir) continue;
    first = glm::min(first, scan.grey.place(i));
    last = glm::max(last, scan.grey.place(i));
  }
  if (last.x < 0) throw Error(file.string(), "labels", "no voxel with a tissue", "some");

  const double voxel = options.voxel.value_or(std::min({scan.spacing.x, scan.spacing.y, scan.spacing.z}));
  const glm::ivec3 margin = glm::ivec3(glm::ceil((options.band + 2 * voxel) / scan.spacing)) + 3;
  const glm::ivec3 lo = first - margin, box = last - first + 1 + 2 * margin;
  const dvec3 extent = dvec3(box - 1) * scan.spacing;
  check_result_size(extent, voxel);
  DenseTissue& out = result.tissue;
  out.size = glm::ivec3(extent / voxel) + 1;
  out.band = options.band;
  out.frame = {scan.origin + dvec3(lo) * scan.spacing, voxel};
  constexpr double kPerMapVoxel = 13, kPerVoxel = 42;  // bytes of memory per voxel of the map; per voxel of the result
  require_memory(
      kPerMapVoxel * static_cast<double>(voxel_count(box)) + kPerVoxel * static_cast<double>(voxel_count(out.size)),
      options, report);

  // For each voxel of the box: its tissue (`label`); 1 for tissue and 0 for air (`inside`).
  Grid<Tissue> label(box, Tissue::kAir);
  Grid<float> inside(box, 0);
  for_each_voxel_in_parallel(last - first + 1, [&](int x, int y, int z) {
    const glm::ivec3 p = first + glm::ivec3(x, y, z);
    const Tissue tissue = tissue_at(scan.grey[p]);
    label[p - lo] = tissue;
    inside[p - lo] = tissue == Tissue::kAir ? 0 : 1;
  });
  report.bodies_found = report.bodies_kept = [&] {
    Mask mask(box, 0);
    std::ranges::transform(inside.v, mask.v.begin(), [](float v) { return static_cast<std::uint8_t>(v); });
    return static_cast<int>(find_bodies(mask).size());
  }();
  inside = gaussian(inside, kBorderBlur);
  const dvec3 ratio = voxel / scan.spacing;
  const auto set = whole_box(out.size);
  Sparse<float> phi(set, -0.5F, 0.5F);
  for_each_sample(*set,
                  [&](const glm::ivec3& p, std::size_t i) { phi.v[i] = sample(inside, dvec3(p) * ratio) - 0.5F; });
  inside = Grid<float>();
  const DistanceField field = signed_distance(phi, out.size, {}, options.band / voxel, options.band / voxel);

  out.distance.resize(voxel_count(out.size));
  out.tissue.assign(out.distance.size(), Tissue::kAir);
  if (options.greys) result.grey.resize(out.distance.size());
  for_each_voxel_in_parallel(out.size, [&](int x, int y, int z) {
    const glm::ivec3 at(x, y, z);
    const std::size_t i = out.at(x, y, z);
    const double d = field.distance[at];
    out.distance[i] = static_cast<float>(std::clamp(d * voxel, -out.band, out.band));
    const dvec3 q = dvec3(at) * ratio;
    if (options.greys) result.grey[i] = static_cast<float>(label[glm::ivec3(glm::round(q))]);
    if (d > kLabelReach) return;
    // Outside the tissue, and where smoothing filled a corner, takes the label of the nearest labelled voxel.
    const dvec3 p = d > 0 ? dvec3(field.closest[at]) * ratio : q;
    const glm::ivec3 near = glm::ivec3(glm::round(p));
    double least = 1e9;
    constexpr int kSearch = 2;
    for_each_voxel_between(near - kSearch, near + kSearch, [&](const glm::ivec3& v) {
      if (!label.holds(v) || label[v] == Tissue::kAir) return;
      const double away = glm::length((dvec3(v) - p) * scan.spacing);
      if (away < least) least = away, out.tissue[i] = label[v];
    });
  });
  return result;
}

}  // namespace typodont::haptics::importing
