#include "haptics/import/partial_volume.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace typodont::haptics::importing {

namespace {

constexpr int kBall = 6;  // voxels, radius of the ball; it reaches beyond the far side of a thin layer or canal

// A sample of the ball around a sample, in which the sum of the fractions is compared with the labels.
struct BallSample {
  glm::ivec3 step;  // position relative to the middle of the ball
  double label;     // weight of the sample's label; it decreases from 1 in the middle to 0 at the edge of the ball
  // Weight of the sample's fraction. The blur spreads a thin tissue to samples with a smaller weight; these weights are
  // therefore sharpened, so that the blur does not change the weighted sum.
  double fraction;
};

std::vector<BallSample> ball_samples(double blur) {
  std::vector<BallSample> ball;
  constexpr double kSquared = kBall * kBall;
  for (int x = -kBall; x <= kBall; ++x) {
    for (int y = -kBall; y <= kBall; ++y) {
      for (int z = -kBall; z <= kBall; ++z) {
        const double r = (x * x + y * y + z * z) / kSquared;
        if (r >= 1) continue;
        // The blur increases the mean of a function w of the position by blur²/2 · ∇²w. With w = (1 − r)², where r is
        // the squared distance divided by the squared radius, ∇²w = (20 r − 12) / kSquared.
        const double weight = (1 - r) * (1 - r);
        ball.push_back({{x, y, z}, weight, weight - 0.5 * blur * blur * (20 * r - 12) / kSquared});
      }
    }
  }
  return ball;
}

struct Ranked {
  float value;
  double weight;
};

// Returns the value that samples with the total weight `volume` exceed. `samples` are in decreasing order of their
// values. Between two samples, the value is interpolated.
float exceeded_by(const std::vector<Ranked>& samples, double volume) {
  double above = 0;  // total weight of the samples before sample k
  for (std::size_t k = 0; k < samples.size(); ++k) {
    // Half of a sample's own weight counts as above its value.
    const double middle = above + 0.5 * samples[k].weight;
    if (middle >= volume) {
      if (k == 0) return samples[0].value;
      const double before = above - 0.5 * samples[k - 1].weight;
      return std::lerp(samples[k - 1].value, samples[k].value,
                       static_cast<float>((volume - before) / (middle - before)));
    }
    above += samples[k].weight;
  }
  return samples.back().value;
}

}  // namespace

void match_volume(Sparse<float>& field, const Sparse<float>& fraction, const SparseMask& border, const SparseMask& body,
                  double blur) {
  const std::vector<BallSample> ball = ball_samples(blur);
  const BlockSet& set = *field.set;
  Sparse<float> matched = field;
  tbb::enumerable_thread_specific<std::vector<Ranked>> scratch;
  for_each_sample(set, [&](const glm::ivec3& p, std::size_t i) {
    if (!border.v[i]) return;
    std::vector<Ranked>& samples = scratch.local();
    samples.clear();
    double volume = 0;
    for (const BallSample& of_ball : ball) {
      const glm::ivec3 q = p + of_ball.step;
      if (!set.holds(q)) continue;
      const std::ptrdiff_t k = field.index(q);
      if (k < 0) continue;
      const auto j = static_cast<std::size_t>(k);
      volume += of_ball.fraction * static_cast<double>(fraction.v[j]);
      if (body.v[j]) samples.push_back({field.v[j], of_ball.label});
    }
    if (samples.empty()) return;
    std::ranges::sort(samples, [](const Ranked& a, const Ranked& b) { return a.value > b.value; });
    matched.v[i] = field.v[i] - exceeded_by(samples, volume);
  });
  field = std::move(matched);
}

}  // namespace typodont::haptics::importing
