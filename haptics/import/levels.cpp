#include "haptics/import/levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "engine/base/error.h"
#include "engine/base/quantile.h"

namespace typodont::haptics::importing {

// Grey values at the volume's walls (outer faces), which are mostly surroundings.
static std::vector<float> walls(const Grid<float>& g) {
  std::vector<float> values;
  for (int x = 0; x < g.size.x; ++x) {
    for (int y = 0; y < g.size.y; ++y) {
      const bool edge = x == 0 || y == 0 || x == g.size.x - 1 || y == g.size.y - 1;
      for (int z = 0; z < g.size.z; z += edge ? 1 : std::max(1, g.size.z - 1)) values.push_back(g(x, y, z));
    }
  }
  return values;
}

static double spread(std::vector<float> values, double middle) {
  for (float& v : values) v = std::abs(v - static_cast<float>(middle));
  // Estimates the standard deviation from the median of absolute deviations.
  return 1.4826 * lower_quantile(values, 0.5);
}

std::vector<Peak> peaks_of(const Grid<float>& greys, double blur) {
  constexpr int kBins = 512;
  const auto [lo_it, hi_it] = std::minmax_element(greys.v.begin(), greys.v.end());
  const double lo = *lo_it, hi = *hi_it;
  if (!(hi > lo)) return {{lo, 1}};
  const double width = (hi - lo) / kBins;
  std::vector<double> count(kBins, 0);
  // Counts only samples in uniform regions, because voxels at edges are mixtures.
  const double steepest = std::max(0.04 * (hi - lo), 3 * blur);
  std::vector<std::array<std::uint32_t, kBins>> counts(static_cast<std::size_t>(greys.size.x));
  for_each_in_parallel(greys.size.x, [&](int x) {
    auto& own = counts[static_cast<std::size_t>(x)];
    own.fill(0);
    const float* slab[3] = {&greys(std::max(x - 1, 0), 0, 0), &greys(x, 0, 0),
                            &greys(std::min(x + 1, greys.size.x - 1), 0, 0)};
    const int ny = greys.size.y, nz = greys.size.z;
    for (int y = 0; y < ny; ++y) {
      const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(y) * nz, up = y + 1 < ny ? nz : 0, down = y > 0 ? nz : 0;
      for (int z = 0; z < nz; ++z) {
        const float* at = slab[1] + row + z;
        const double dx = 0.5 * (static_cast<double>(slab[2][row + z]) - static_cast<double>(slab[0][row + z])),
                     dy = 0.5 * (static_cast<double>(at[up]) - static_cast<double>(at[-down])),
                     dz = 0.5 * (static_cast<double>(at[z + 1 < nz]) - static_cast<double>(at[z > 0 ? -1 : 0]));
        if (dx * dx + dy * dy + dz * dz > steepest * steepest) continue;
        ++own[static_cast<std::size_t>(std::min(kBins - 1, static_cast<int>((static_cast<double>(*at) - lo) / width)))];
      }
    }
  });
  for (const auto& own : counts) {
    for (std::size_t bin = 0; bin < kBins; ++bin) count[bin] += own[bin];
  }
  // Width of the histogram's smoothing, from the noise, within limits; bins.
  const double sigma = std::clamp(blur / width, 4.0, 40.0);
  std::vector<double> h(kBins, 0);
  const int r = static_cast<int>(4 * sigma);
  double norm = 0;
  for (int k = -r; k <= r; ++k) norm += std::exp(-0.5 * k * k / (sigma * sigma));
  for (int i = 0; i < kBins; ++i) {
    if (count[static_cast<std::size_t>(i)] <= 0) continue;
    for (int k = -r; k <= r; ++k) {
      if (i + k < 0 || i + k >= kBins) continue;
      h[static_cast<std::size_t>(i + k)] +=
          count[static_cast<std::size_t>(i)] * std::exp(-0.5 * k * k / (sigma * sigma)) / norm;
    }
  }
  // Adds bins to peaks, highest bin first. If a peak rises above the valley beside a higher peak by less than 40 %
  // of its own height, it is joined to the higher peak.
  struct Hill {
    int top;
    double pass = 0;
    double mass = 0;
  };
  std::vector<Hill> hills;
  std::vector<int> owner(kBins, -1), order(kBins);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return h[static_cast<std::size_t>(a)] > h[static_cast<std::size_t>(b)]; });
  std::vector<int> merged;
  const auto root = [&](int hill) {
    while (merged[static_cast<std::size_t>(hill)] != hill) hill = merged[static_cast<std::size_t>(hill)];
    return hill;
  };
  std::vector<int> flooded(kBins, -1);
  for (const int bin : order) {
    const int left = bin > 0 && flooded[static_cast<std::size_t>(bin - 1)] >= 0
                         ? root(flooded[static_cast<std::size_t>(bin - 1)])
                         : -1;
    const int right = bin + 1 < kBins && flooded[static_cast<std::size_t>(bin + 1)] >= 0
                          ? root(flooded[static_cast<std::size_t>(bin + 1)])
                          : -1;
    int mine;
    if (left < 0 && right < 0) {
      mine = static_cast<int>(hills.size());
      hills.push_back({bin});
      merged.push_back(mine);
    } else if (left < 0 || right < 0 || left == right) {
      mine = left >= 0 ? left : right;
      // This bin is the valley between two peaks: the smaller peak is complete.
    } else {
      const bool left_higher = h[static_cast<std::size_t>(hills[static_cast<std::size_t>(left)].top)] >=
                               h[static_cast<std::size_t>(hills[static_cast<std::size_t>(right)].top)];
      const int high = left_higher ? left : right, low = left_higher ? right : left;
      Hill& lower = hills[static_cast<std::size_t>(low)];
      const double top = h[static_cast<std::size_t>(lower.top)];
      if (top - h[static_cast<std::size_t>(bin)] < 0.4 * top) {
        for (int& o : owner) o = o == low ? high : o;
        lower.top = -1;
      }
      merged[static_cast<std::size_t>(low)] = high;
      mine = high;
    }
    flooded[static_cast<std::size_t>(bin)] = mine;
    // A bin of the histogram belongs to the peak that is reached from the bin by steps to the higher neighbour bin.
    int climb = bin;
    while (true) {
      const double here = h[static_cast<std::size_t>(climb)];
      const double l = climb > 0 ? h[static_cast<std::size_t>(climb - 1)] : -1,
                   rr = climb + 1 < kBins ? h[static_cast<std::size_t>(climb + 1)] : -1;
      if (l <= here && rr <= here) break;
      climb += l > rr ? -1 : 1;
    }
    owner[static_cast<std::size_t>(bin)] =
        owner[static_cast<std::size_t>(climb)] >= 0 ? owner[static_cast<std::size_t>(climb)] : mine;
  }
  double total = 0;
  for (int i = 0; i < kBins; ++i) {
    total += count[static_cast<std::size_t>(i)];
    if (owner[static_cast<std::size_t>(i)] >= 0)
      hills[static_cast<std::size_t>(owner[static_cast<std::size_t>(i)])].mass += count[static_cast<std::size_t>(i)];
  }
  std::vector<Peak> peaks;
  for (const Hill& hill : hills) {
    if (hill.top < 0) continue;
    // Position of the peak from a parabola through three bins.
    const auto t = static_cast<std::size_t>(hill.top);
    double shift = 0;
    if (t > 0 && t + 1 < kBins) {
      const double bend = h[t - 1] - 2 * h[t] + h[t + 1];
      if (bend < 0) shift = std::clamp(0.5 * (h[t - 1] - h[t + 1]) / bend, -0.5, 0.5);
    }
    peaks.push_back({lo + (hill.top + 0.5 + shift) * width, hill.mass / total});
  }
  std::sort(peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) { return a.level < b.level; });
  return peaks;
}

namespace {

/// Scale of grey values: Hounsfield units plus a constant. Air −1000, water 0, soft tissue −120 (fat) to 80.
struct HounsfieldScale {
  double offset;
  std::string source;  // how the scale was found, for the user
};

/// Finds air and soft tissue as peaks about 1000 apart. Otherwise tests whether the darkest and brightest value, `lo`
/// and `hi`, can be plain Hounsfield units. Otherwise nullopt.
std::optional<HounsfieldScale> hounsfield_of(const std::vector<Peak>& peaks, double lo, double hi) {
  constexpr double kAir = -1000, kMinApart = 880, kMaxApart = 1100;
  // Plausible range of the brightest voxel, from bone to metal, Hounsfield units.
  constexpr double kMinBone = 300, kMost = 8000;
  // Smallest fraction of all voxels that each of the two peaks (air, soft tissue) contains.
  constexpr double kMinMass = 0.01;
  // Usual grey values of 0 Hounsfield units, most frequent first. If one is nearer than kNear, the offset is set to it.
  constexpr double kUsual[] = {0, 1024, 1000, -24}, kNear = 60;
  std::optional<HounsfieldScale> found;
  for (const Peak& air : peaks) {
    for (const Peak& soft : peaks) {
      const double apart = soft.level - air.level;
      if (apart < kMinApart || apart > kMaxApart || air.mass < kMinMass || soft.mass < kMinMass) continue;
      double offset = air.level - kAir;
      bool usual = false;
      const double* nearest =
          std::ranges::min_element(kUsual, {}, [&](double o) { return std::abs(air.level - kAir - o); });
      if (std::abs(offset - *nearest) < kNear) offset = *nearest, usual = true;
      if (hi - offset < kMinBone || hi - offset > kMost) continue;
      if (found && !usual) continue;
      found = {offset, fmt::format("air at {:.4g}, soft tissue at {:.4g}", air.level, soft.level)};
      if (usual) return found;
    }
  }
  if (!found && lo < -800 && lo > -1200 && hi > kMinBone && hi < 6000)
    found = {0, fmt::format("greys from {:.4g} to {:.4g}", lo, hi)};
  return found;
}

/// Peak with the most voxels between two grey values; very small peaks are ignored.
std::optional<double> hill_between(const std::vector<Peak>& peaks, double low, double high) {
  constexpr double kMinMass = 0.002;
  const Peak* best = nullptr;
  for (const Peak& p : peaks) {
    if (p.level > low && p.level < high && p.mass > kMinMass && (!best || p.mass > best->mass)) best = &p;
  }
  return best ? std::optional(best->level) : std::nullopt;
}

/// Uses the user's thresholds: the surface lies at the threshold, and peaks give the grey values on both sides, if
/// there are any.
void use_thresholds(const std::filesystem::path& file, const std::vector<Peak>& peaks, const ImportOptions& options,
                    double brightest, Levels& levels) {
  if (options.surface_grey) {
    const double surface = *options.surface_grey, most = options.dense_grey.value_or(brightest);
    if (!(surface > levels.outside) || !(surface < brightest)) {
      throw Error(
          file.string(), "--thresholds", fmt::format("{:g} for the surface", surface),
          fmt::format("a grey above the surround's {:.6g} and below the brightest, {:.6g}", levels.outside, brightest));
    }
    // Grey value beside the tissue: the largest peak below the threshold. Without such a peak, `outside` is kept.
    if (const auto below = hill_between(peaks, levels.outside, surface)) levels.outside = *below;
    // Grey value of the tissue, if the threshold is half-way between surroundings and tissue.
    const double even = 2 * surface - levels.outside;
    const double reach = 0.5 * (even - surface);
    const bool fits = even < most && hill_between(peaks, even - reach, std::min(even + reach, most));
    const auto above = hill_between(peaks, surface, most);
    levels.soft = fits || (even < most && !above) ? even : above ? *above : 0.5 * (surface + most);
    constexpr double kMinHeight = 0.15, kMaxHeight = 0.85;
    levels.height = std::clamp((surface - levels.outside) / (levels.soft - levels.outside), kMinHeight, kMaxHeight);
    levels.soft = levels.outside + (surface - levels.outside) / levels.height;
  }
  if (options.dense_grey) {
    levels.dense = 2 * *options.dense_grey - levels.soft;
    if (!(*levels.dense > levels.soft)) {
      throw Error(file.string(), "--thresholds", fmt::format("{:g} for the denser tissue", *options.dense_grey),
                  fmt::format("a grey above the softer tissue's {:.6g}", levels.soft));
    }
  }
}

}  // namespace

Levels find_levels(const std::filesystem::path& file, const Grid<float>& grey, const Grid<float>& smoothed,
                   const ImportOptions& options, std::vector<std::string>& notes) {
  Levels levels;
  std::vector<float> wall = walls(grey);
  double middle = lower_quantile(wall, 0.5);
  levels.noise = spread(wall, middle);
  std::vector<float> smooth_wall = walls(smoothed);
  levels.smoothed_noise = spread(smooth_wall, lower_quantile(smooth_wall, 0.5));

  const std::vector<Peak> peaks = peaks_of(smoothed, levels.smoothed_noise);
  const auto [lo, hi] = std::minmax_element(smoothed.v.begin(), smoothed.v.end());
  const double range = static_cast<double>(*hi) - static_cast<double>(*lo);
  if (!(range > 0)) {
    throw Error(file.string(), "greys", fmt::format("the same value {:g} everywhere", *lo),
                "tissue in a darker surround");
  }
  // On the scale of Hounsfield units, grey values of tissues are known.
  std::optional<HounsfieldScale> hounsfield;
  if (options.hounsfield)
    hounsfield = {*options.hounsfield, "as was said"};
  else if (options.preset != ImportPreset::kTooth && !options.surface_grey)
    hounsfield = hounsfield_of(peaks, *lo, *hi);

  levels.outside = middle;
  for (const Peak& p : peaks) {
    if (std::abs(p.level - middle) < std::max(3 * levels.smoothed_noise, 0.03 * range)) levels.outside = p.level;
  }
  // Peaks of the histogram that are brighter than the surroundings, without soft tissue and pulp.
  std::vector<Peak> tissues;
  double bright = 0, top = levels.outside;
  for (const Peak& p : peaks) {
    if (p.level > levels.outside + std::max(5 * levels.smoothed_noise, 0.03 * range)) {
      tissues.push_back(p);
      bright += p.mass;
    }
  }
  std::erase_if(tissues, [&](const Peak& p) { return p.mass < 0.01 * bright; });
  for (const Peak& p : tissues) top = std::max(top, p.level);
  double most = 0;
  for (const Peak& p : tissues) most = std::max(most, p.mass);
  std::erase_if(tissues, [&](const Peak& p) {
    const double height = (p.level - levels.outside) / (top - levels.outside);
    return height < 0.12 || (height < 0.3 && p.mass < 0.5 * most);
  });
  std::sort(tissues.begin(), tissues.end(), [](const Peak& a, const Peak& b) { return a.mass > b.mass; });
  if (tissues.size() > 2) {
    if (options.preset != ImportPreset::kJaw)
      notes.push_back(
          fmt::format("{} hills of tissue in the histogram; the two with most voxels are taken", tissues.size()));
    tissues.resize(2);
  }
  std::sort(tissues.begin(), tissues.end(), [](const Peak& a, const Peak& b) { return a.level < b.level; });

  if (hounsfield && !options.surface_grey) {
    // First estimates in Hounsfield units, which put the surface at 300; segment() improves them.
    constexpr double kSoftTissue = 0, kCancellous = 600;
    levels.outside = hounsfield->offset + kSoftTissue;
    levels.soft = hounsfield->offset + kCancellous;
    if (!(*hi > levels.surface())) {
      throw Error(
          file.string(), "greys", fmt::format("nothing above {:.6g}", levels.surface()),
          fmt::format("bone, in Hounsfield units plus {:g}; --hounsfield OFFSET says otherwise", hounsfield->offset));
    }
    notes.push_back(
        fmt::format("greys taken as Hounsfield units{} ({}): soft tissue 0{}",
                    hounsfield->offset == 0 ? "" : fmt::format(" {:+g}", hounsfield->offset), hounsfield->source,
                    options.preset == ImportPreset::kBone ? ", cortical bone above 850 (Misch D1 and D2)" : ""));
  } else if (!options.surface_grey && tissues.empty()) {
    throw Error(file.string(), "greys", fmt::format("no tissue brighter than the surround ({:.6g})", levels.outside),
                "one or two hills of tissue in the histogram, or --thresholds");
  } else if (!options.surface_grey) {
    levels.soft = tissues[0].level;
  }
  use_thresholds(file, peaks, options, *hi, levels);
  if (hounsfield) levels.hounsfield = hounsfield->offset;
  levels.fixed_surround = options.surface_grey.has_value() || hounsfield.has_value();
  levels.fixed_dense = options.dense_grey.has_value() || hounsfield.has_value();
  if (options.dense_grey) return levels;
  if (hounsfield) {
    constexpr double kCortical = 850;
    levels.dense = std::max(2 * (hounsfield->offset + kCortical) - levels.soft, levels.soft + 1);
  } else if (tissues.size() == 2 && tissues[1].level > levels.soft) {
    levels.dense = tissues[1].level;
    if (options.preset == ImportPreset::kBone && !options.surface_grey) {
      notes.push_back(fmt::format(
          "the scale of the greys is not known: {:.4g} is taken as cancellous, {:.4g} as cortical bone; where "
          "the first is soft tissue, give --hounsfield OFFSET (e.g. 1024) or --thresholds",
          levels.soft, *levels.dense));
    }
  } else {
    notes.push_back(options.preset == ImportPreset::kTooth
                        ? "one grey of tissue only: all of it is labelled dentin"
                        : "one grey of tissue only: all of it is labelled cortical bone");
  }
  return levels;
}

}  // namespace typodont::haptics::importing
