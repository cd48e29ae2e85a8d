// Typical grey values of a tissue, in the whole scan and near each sample.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {

/// Most frequent value, within ± `width`, of the samples i for which counts(i) is true; nullopt if there are too few.
/// Of large volumes, only every n-th sample is used.
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

/// Local mean of grey values: smoothed means of cells of 4³ samples. Where only few samples are used, the local mean
/// approaches the mean of the whole scan.
class LocalGrey {
 public:
  /// Smooths the samples of `set`. `grey(p)`: value of sample p; `counts(p, i)`: whether the sample is used;
  /// `everywhere`: mean of the whole scan.
  template <class Grey, class Counts>
  LocalGrey(Grey grey, const BlockSet& set, double everywhere, Counts counts)
      : everywhere_(everywhere), sum_((set.size + 3) / 4, 0.0F), weight_(sum_.size, 0.0F) {
    // Each cell lies in one block, so threads never write to the same cell.
    for_each_sample(set, [&](const glm::ivec3& p, std::size_t i) {
      if (!counts(p, i)) return;
      const glm::ivec3 cell = p / 4;
      sum_[cell] += static_cast<float>((grey(p) - everywhere) / 64);
      weight_[cell] += 1.0F / 64;
    });
    // Standard deviation of the smoothing, cells. Averaging in cells, this smoothing and the interpolation together
    // smooth over about four samples.
    constexpr double kSigma = 0.87;
    sum_ = gaussian(sum_, kSigma);
    weight_ = gaussian(weight_, kSigma);
  }
  double at(const glm::ivec3& p) const {
    const glm::dvec3 q = (glm::dvec3(p) - 1.5) / 4.0;
    // Weight of the whole scan's mean in the average. All samples near p together have at most the weight 1.
    constexpr double kOfEverywhere = 0.02;
    return everywhere_ +
           static_cast<double>(sample(sum_, q)) / (static_cast<double>(sample(weight_, q)) + kOfEverywhere);
  }

 private:
  double everywhere_;
  Grid<float> sum_, weight_;
};

/// Grey value of a tissue, from samples far from its border. Returns nullopt if fewer than `enough` samples are at
/// least `least` voxels from the border. At the distance z · `blur` from an edge of height H, the blur changes the grey
/// value by H Φ(−z) and the Laplacian by H z φ(z) / blur² (φ, Φ: density and integral of the standard normal
/// distribution). So the Laplacian gives the correction. `blur` 0: no correction.
std::optional<LocalGrey> reference_grey(const Grid<float>& grey, const SparseMask& tissue, std::size_t enough,
                                        double least, double blur);

}  // namespace typodont::haptics::importing
