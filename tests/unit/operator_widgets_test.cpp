// Tests what all pages of the operator's window share: each key has one meaning, and text is not cut within a letter.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>

#include "engine/app/operator/widgets.h"
#include "engine/render/quality.h"

namespace typodont {
namespace {

TEST(Shortcuts, AKeyHasTheSameActionOnEveryPageAndEachActionHasOneKey) {
  std::set<std::pair<int, bool>> keys;
  std::set<std::string_view> names, helps;
  std::set<Ask> asks;
  for (const Shortcut& one : kShortcuts) {
    EXPECT_TRUE(keys.insert({one.code, one.control}).second) << one.name;
    EXPECT_TRUE(names.insert(one.name).second) << one.name;
    EXPECT_TRUE(helps.insert(one.help).second) << one.help;
    EXPECT_TRUE(session::has_text(one.help)) << one.help;
    for (const Ask ask : std::set<Ask>(one.does.begin(), one.does.end())) EXPECT_TRUE(asks.insert(ask).second);
  }
  EXPECT_EQ(shortcut(Ask::kAgain).name, "F5");
  EXPECT_EQ(shortcut(Ask::kStart).name, shortcut(Ask::kAgain).name);
}

/// Returns the width of a text. A Latin letter is one column wide, a Chinese character two.
float columns(std::string_view text) {
  float sum = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte & 0xc0) == 0x80) continue;
    sum += byte >= 0xe3 ? 2.0f : 1.0f;
  }
  return sum;
}

/// Whether it ends where a letter ends.
bool whole_letters(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    const auto byte = static_cast<unsigned char>(text[i]);
    i += byte < 0x80 ? 1 : byte < 0xe0 ? 2 : byte < 0xf0 ? 3 : 4;
  }
  return i == text.size();
}

TEST(Fitted, ATextThatIsTooLongEndsBetweenLettersWithAnEllipsisAndIsNeverWiderThanItsRoom) {
  const std::string texts[] = {"Prepare a class I cavity along the central fissure: 3.9 mm long.",
                               "Präparieren Sie entlang der zentralen Fissur eine Kavität der Klasse I: größtmöglich.",
                               "沿中央窝沟制备 I 类洞：长 3.9 mm，宽 1.5 mm，洞底平整并刚进入牙本质。",
                               "Zahnärztinnenübungsaufgabenbeschreibung"};
  for (const std::string& text : texts) {
    for (float room = 2; room < columns(text) + 2; ++room) {
      const std::string shown = widgets::fitted(text, room, columns);
      EXPECT_LE(columns(shown), room) << shown;
      EXPECT_TRUE(whole_letters(shown)) << shown;
      if (columns(text) <= room) {
        EXPECT_EQ(shown, text);
        continue;
      }
      ASSERT_TRUE(shown.ends_with("…")) << shown;
      EXPECT_TRUE(text.starts_with(shown.substr(0, shown.size() - std::string("…").size()))) << shown;
    }
  }
  EXPECT_EQ(widgets::fitted(texts[0], 20, columns), "Prepare a class I…");
}

TEST(Widgets, ALongTextIsBrokenOnlyAtSpacesSoANumberStaysWhole) {
  const auto columns = [](std::string_view text) { return static_cast<float>(text.size()); };
  EXPECT_EQ(widgets::broken("2.7 mm long, 1.7 mm high", 14, columns), "2.7 mm long,\n1.7 mm high");
  EXPECT_EQ(widgets::broken("a 123456.789 b\nc d", 5, columns), "a\n123456.789\nb\nc d");
  EXPECT_EQ(widgets::broken("", 5, columns), "");
  EXPECT_EQ(widgets::broken("fits", 5, columns), "fits");
}

TEST(Keys, KeysAndQualityLevelsAreNamedInTheReadersLanguage) {
  OperatorState s;
  EXPECT_EQ(s.keys("Ctrl+Z"), "Ctrl+Z");
  s.language = session::Language::kGerman;
  EXPECT_EQ(s.keys("Ctrl+Z"), "Strg+Z");
  EXPECT_EQ(s.keys("Space  Esc"), "Leertaste  Esc");
  EXPECT_EQ(s.keys("F5"), "F5");
  for (const render::Quality& step : render::kQualityLadder)
    EXPECT_TRUE(session::has_text(fmt::format("op.quality.{}", step.name))) << step.name;
}

TEST(RealTime, TheWindowShowsEachPermissionWithTheReportsWords) {
  OperatorState s;
  EXPECT_TRUE(widgets::granted_lines(s).empty()) << "nothing is known before the first tick";
  s.status.timing.ticks = 1;
  s.status.real_time = "not pinned: fewer than three cores";  // no word about the priority, which was granted
  s.status.granted = {.fifo = true, .pinned = false, .memory_locked = true};
  for (const session::Language language : {session::Language::kEnglish, session::Language::kGerman}) {
    s.language = language;
    const auto lines = widgets::granted_lines(s);
    ASSERT_EQ(lines.size(), 3u);
    EXPECT_EQ(lines[0].name, session::text("realtime.fifo", language));
    EXPECT_EQ(lines[0].value, session::text("realtime.yes", language));
    EXPECT_FALSE(lines[1].granted);
    EXPECT_EQ(lines[1].name, session::text("realtime.pinned", language));
    EXPECT_NE(lines[1].value, lines[0].value);
    EXPECT_TRUE(lines[2].granted);
  }
}

TEST(ScoreColor, IsRedBelowThePassMarkAndNotAtIt) {
  const session::PassMark pass{60, "x"};
  const auto same = [](const ImVec4& a, const ImVec4& b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
  EXPECT_TRUE(same(widgets::score_color(0.599, pass), widgets::kBad));
  EXPECT_FALSE(same(widgets::score_color(0.6, pass), widgets::kBad));
  EXPECT_TRUE(same(widgets::score_color(1, pass), widgets::kGood));
}

TEST(CheckOfTheComputer, OnlyAMissingPartThatTheProgramRequiresIsRed) {
  const auto color = [](PartState state, bool required) {
    DoctorFinding finding("id", "name");
    finding.state = state, finding.required = required;
    const ImVec4 c = widgets::severity_color(finding.severity());
    return std::array{c.x, c.y, c.z};
  };
  const auto rgb = [](const ImVec4& c) { return std::array{c.x, c.y, c.z}; };
  for (const bool required : {false, true}) {
    EXPECT_EQ(color(PartState::kOk, required), rgb(widgets::kGood));
    EXPECT_EQ(color(PartState::kDegraded, required), rgb(widgets::kWarn));
  }
  EXPECT_EQ(color(PartState::kMissing, false), rgb(widgets::kWarn));
  EXPECT_EQ(color(PartState::kMissing, true), rgb(widgets::kBad));
  for (const char* name : {"ok", "degraded", "missing"}) EXPECT_EQ(name_of(part_state_named(name)), name);
}

}  // namespace
}  // namespace typodont
