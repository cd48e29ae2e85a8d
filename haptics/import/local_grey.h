// Measures the grey values of tissues and surroundings, in the whole scan and near each sample.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {

/// Returns the most frequent grey value of the samples for which counts(i) is true, or no value if there are too few.
/// In a large volume, only every n-th sample is used.
template <class Counts>
std::optional<double> mode_of(const Sparse<float>& greys, double width, Counts counts) {
  constexpr std::size_t kEnough = 20'000'000;
  std::vector<float> values;
  for (std::size_t i = 0; i < greys.v.size(); i += 1 + greys.v.size() / kEnough) {
    if (counts(i)) values.push_back(greys.v[i]);
  }
  if (values.size() < 50) return std::nullopt;
  std::sort(values.begin(), values.end());
  std::size_t best = 0, lo = 0;
  double mode = static_cast<double>(values.back());
  for (std::size_t hi = 0; hi < values.size(); ++hi) {
    while (values[hi] - values[lo] > static_cast<float>(2 * width)) ++lo;
    if (hi - lo > best)
      best = hi - lo, mode = 0.5 * (static_cast<double>(values[lo]) + static_cast<double>(values[hi]));
  }
  return mode;
}

/// Finds the grey value of a tissue or of the surroundings near a sample: the mean over cells of 4³ samples, which is
/// then smoothed. If hardly any samples nearby belong to the tissue or the surroundings (in a fissure), it is the mean
/// grey value in the whole scan.
class LocalGrey {
 public:
  /// `grey` returns the grey value of a sample. `counts` returns true for the samples that are used.
  template <class Grey, class Counts>
  LocalGrey(Grey grey, const BlockSet& set, double everywhere, Counts counts)
      : everywhere_(everywhere), sum_((set.size + 3) / 4, 0.0F), weight_(sum_.size, 0.0F) {
    // The loop runs in parallel over blocks. Each cell lies in a single block, so two threads never write the same
    // cell.
    for_each_sample(set, [&](const glm::ivec3& p, std::size_t i) {
      if (!counts(p, i)) return;
      const glm::ivec3 cell = p / 4;
      sum_[cell] += static_cast<float>((grey(p) - everywhere) / 64);
      weight_[cell] += 1.0F / 64;
    });
    // Standard deviation of the smoothing, in units of cells. Together with the mean over a cell and the interpolation
    // between cells, the smoothing then has a standard deviation of about four samples.
    constexpr double kSigma = 0.87;
    sum_ = gaussian(sum_, kSigma);
    weight_ = gaussian(weight_, kSigma);
  }
  double at(const glm::ivec3& p) const {
    const glm::dvec3 q = (glm::dvec3(p) - 1.5) / 4.0;
    // Weight of the mean grey value in the whole scan. For comparison: the samples nearby have the weight 1 if all of
    // them are used.
    constexpr double kOfEverywhere = 0.02;
    return everywhere_ +
           static_cast<double>(sample(sum_, q)) / (static_cast<double>(sample(weight_, q)) + kOfEverywhere);
  }

 private:
  double everywhere_;
  Grid<float> sum_, weight_;
};

/// Returns the mean grey value of the samples of `tissue` that are far from its border: first the mean of all such
/// samples, then the local mean near each sample. Returns no value if there are fewer than `enough` such samples at the
/// distance `least` (voxels) or more. `blur` is the standard deviation of the scan's blur in voxels. At the distance z
/// · blur from an edge, a Gaussian blur changes the grey value by Φ(−z) times the height of the edge, and the sum of
/// the second derivatives is z φ(z) / blur² times this height. The change of the grey value is computed from this sum
/// and removed. If `blur` is 0, the grey values are used unchanged.
std::optional<LocalGrey> reference_grey(const Grid<float>& grey, const SparseMask& tissue, std::size_t enough,
                                        double least, double blur);

}  // namespace typodont::haptics::importing
