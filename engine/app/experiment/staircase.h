// Adaptive staircases: they choose the next trial's difference from the earlier answers. Any thread.
#pragma once

#include <cmath>
#include <vector>

namespace typodont {

/// Rule of a staircase. The level is the difference between the stimuli of a trial. It changes by ratios, so it never
/// reaches 0.
struct StaircaseRule {
  enum class Kind {
    /// The level falls after `down` right answers in a row, and rises after each wrong answer (Levitt 1971).
    kTransformed,
    /// The level falls a little after each right answer, and rises more after each wrong one (Kaernbach 1991).
    kWeighted
  };
  Kind kind = Kind::kTransformed;
  /// For kTransformed: the level settles where the fraction of right answers is 0.5^(1/down).
  int down = 2;
  double weighted_at = 0.75;  // for kWeighted: fraction of right answers where the staircase settles
  double start = 50;          // level of the first trial, in the experiment's unit
  double least = 1e-3, most = 100;
  double first_step = 1.6;  // factor of a change of level, until `coarse` reversals happened; kWeighted: of a fall only
  double step = 1.2;        // factor of a change of level, after `coarse` reversals; kWeighted: of a fall only
  int coarse = 3;           // number of reversals with `first_step`

  /// Fraction of right answers where the staircase settles.
  double target() const { return kind == Kind::kTransformed ? std::pow(0.5, 1.0 / down) : weighted_at; }
};

class Staircase {
 public:
  explicit Staircase(const StaircaseRule& rule) : rule_(rule), level_(clamped(rule.start)) {}

  /// Level of the next trial.
  double level() const { return level_; }
  /// Takes the current trial's answer. `right`: the answer was right.
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
  /// Number of reversals of direction so far.
  int turns() const { return static_cast<int>(turns_.size()); }
  /// Geometric mean of the levels at the last reversals (an even number), without the first `coarse` ones. 0: too few
  /// reversals.
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
  int in_a_row_ = 0;   // number of right answers since the last change of level
  int direction_ = 0;  // latest change of the level: 1 up, −1 down, 0 none
  std::vector<double> turns_;
};

}  // namespace typodont
