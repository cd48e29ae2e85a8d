// Adaptive staircases: rules that choose the difference of the next trial from the earlier answers. For any thread.
#pragma once

#include <cmath>
#include <vector>

namespace typodont {

/// Rule of a staircase. The level is the difference between the stimuli of a trial. Each change multiplies or divides
/// the level by a ratio, so the level never reaches 0.
struct StaircaseRule {
  enum class Kind {
    /// With this kind of staircase, the level falls after `down` consecutive right answers, and rises after each wrong
    /// answer (Levitt 1971).
    kTransformed,
    /// With this kind of staircase, the level falls by a small ratio after each right answer, and rises by a larger
    /// ratio after each wrong answer (Kaernbach 1991).
    kWeighted
  };
  Kind kind = Kind::kTransformed;
  /// kTransformed: number of right answers after which the level falls. The staircase settles where the fraction of
  /// right answers is 0.5^(1/down).
  int down = 2;
  double weighted_at = 0.75;  // kWeighted: fraction of right answers at which the staircase settles
  double start = 50;          // first level (difference between the stimuli), in the experiment's unit
  double least = 1e-3, most = 100;
  double first_step = 1.6;  // ratio between two successive levels during the first `coarse` reversals
  double step = 1.2;        // ratio between two successive levels after the first `coarse` reversals
  int coarse = 3;           // number of reversals at the start during which the ratio between levels is `first_step`

  /// Returns the fraction of right answers at the level where the staircase settles.
  double target() const { return kind == Kind::kTransformed ? std::pow(0.5, 1.0 / down) : weighted_at; }
};

class Staircase {
 public:
  explicit Staircase(const StaircaseRule& rule) : rule_(rule), level_(clamped(rule.start)) {}

  /// Returns the level (difference between the stimuli) of the next trial.
  double level() const { return level_; }
  /// Changes the level after an answer to the present trial. `right`: true if the answer was right.
  void answer(bool right) {
    if (right && rule_.kind == StaircaseRule::Kind::kTransformed && ++in_a_row_ < rule_.down) return;
    in_a_row_ = 0;
    const int direction = right ? -1 : 1;
    if (direction_ != 0 && direction != direction_) turns_.push_back(level_);
    direction_ = direction;
    double step = std::log(static_cast<int>(turns_.size()) < rule_.coarse ? rule_.first_step : rule_.step);
    if (rule_.kind == StaircaseRule::Kind::kWeighted && !right) step *= rule_.weighted_at / (1 - rule_.weighted_at);
    level_ = clamped(level_ * std::exp(direction * step));
  }
  /// Returns the number of reversals so far. A reversal is a change from falling to rising levels, or from rising to
  /// falling levels.
  int turns() const { return static_cast<int>(turns_.size()); }
  /// Returns the geometric mean of the levels at the reversals after the first `coarse` reversals. Only an even number
  /// of reversals is used. 0 if there are too few reversals.
  double settled_level() const {
    const int usable = (turns() - rule_.coarse) / 2 * 2;
    if (usable < 2) return 0;
    double sum = 0;
    for (int i = turns() - usable; i < turns(); ++i) sum += std::log(turns_[static_cast<std::size_t>(i)]);
    return std::exp(sum / usable);
  }

 private:
  double clamped(double level) const { return std::min(std::max(level, rule_.least), rule_.most); }

  StaircaseRule rule_;
  double level_;
  int in_a_row_ = 0;   // number of right answers since the level last changed
  int direction_ = 0;  // sign of the last change of the level: 1 up, -1 down, 0 no change yet
  std::vector<double> turns_;
};

}  // namespace typodont
