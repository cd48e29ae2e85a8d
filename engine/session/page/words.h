// Texts of a session's report in the reader's language.
#pragma once

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <string_view>

#include "engine/session/page/plot.h"
#include "engine/session/score.h"
#include "engine/session/session_data.h"
#include "engine/session/strings.h"

namespace typodont::session {

struct Words {
  Language language = Language::kEnglish;

  /// A catalogue text with its placeholders filled in, no markup.
  template <class... Args>
  std::string say(std::string_view key, Args&&... args) const {
    return fmt::format(fmt::runtime(text(key, language)), std::forward<Args>(args)...);
  }
  std::string number(double v, int decimals) const { return session::number_text(v, decimals, language); }
  std::string number(double v) const { return session::number_text(v, language); }
  std::string quantity(double v, std::string_view unit) const { return quantity_text(v, unit, language); }
  std::string target(const ScoreItem& item) const {
    const std::string value = quantity(item.target, item.unit);
    switch (item.best) {
      case Best::kAtMost:
        return say("at_most", value);
      case Best::kAtLeast:
        return say("at_least", value);
      case Best::kNear:
        return value;
    }
    return value;
  }
  /// The total points. A missed pass is red, with a cross for colour-blind readers.
  std::string total(const Score& score) const {
    if (!score.counts()) return "–";
    return marked(number(printed_points(score.points), 1), !score.passed());
  }
  std::string marked(const std::string& points, bool missed) const {
    if (!missed) return points;
    return fmt::format("<span class=\"missed\"><span role=\"img\" aria-label=\"{}\">✗</span> {}</span>",
                       escaped(say("below_pass")), points);
  }
  std::string name_of_item(const std::string& name) const {
    const std::string key = "score." + name;
    return has_text(key) ? say(key) : escaped(name);
  }
  /// A date of a file as local time, "2025-01-02 04:04"; escaped.
  std::string date(const std::string& iso) const {
    const auto local = local_time(iso);
    return escaped(local ? local->text : iso);
  }
  NumberText number_text() const {
    return [words = *this](double v, int decimals) { return words.number(v, decimals); };
  }
};

}  // namespace typodont::session
