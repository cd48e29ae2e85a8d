// Tests texts over the picture of a session: every text exists in three languages, every character is in the font, and
// pictures of them are correct.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "engine/app/picture/hud.h"
#include "tests/support/stage.h"

namespace typodont::test {
namespace {

using display::Hud;
using display::Writing;
using session::Language;

const std::string kHint = "left button: drill   wheel: in and out   Z, Y: undo, redo   V: view   space or Esc: stop";
constexpr Language kLanguages[] = {Language::kEnglish, Language::kGerman, Language::kChinese};

/// Returns the catalogue keys whose texts can appear over a picture.
std::vector<std::string> keys_over_pictures() {
  std::vector<std::string> keys;
  for (const std::string_view key : session::catalogue_keys())
    for (const char* prefix : {"hud.", "tool.", "implant.note.", "op.quality."})
      if (key.starts_with(prefix)) keys.emplace_back(key);
  return keys;
}

bool has_chinese_font() {
  return display::can_write("已");
}

/// Returns texts with a tool, a speed, a force and the longest hint of a session.
Hud hud_in(Language language) {
  Hud hud;
  hud.visible = true;
  hud.tool = fmt::format("{} 1 mm", session::tool_text("end_guarded_cylinder_010", language));
  hud.speed_krpm = 300;
  hud.force = 1.25;
  hud.words = hud_words(language);
  hud.hint = hud_text(language, "mouse", short_number(0.15, 3, language));
  for (const char* key : {"undo", "view", "suction", "water", "suction_on", "water_off", "disk_low", "stop"})
    hud.hint.append(kHudGap).append(hud_text(language, key));
  return hud;
}

/// How many pixels of a panel are letters.
int letters(const Writing::Panel& panel) {
  int count = 0;
  for (std::size_t i = 0; i < panel.rgba.size(); i += 4) count += panel.rgba[i] > 120;
  return count;
}

TEST(HudTexts, DifferFromTheEnglishOnesInTheOtherLanguages) {
  for (const std::string& key : keys_over_pictures())
    for (const Language language : {Language::kGerman, Language::kChinese})
      if (key.starts_with("hud.")) {
        EXPECT_NE(session::text(key, language), session::text(key, Language::kEnglish)) << key;
      }
}

TEST(HudTexts, UseOnlyCharactersOfTheFont) {
  for (const Language language : kLanguages) {
    if (language == Language::kChinese && !has_chinese_font()) continue;
    for (const std::string& key : keys_over_pictures())
      EXPECT_TRUE(display::can_write(session::text(key, language))) << key << ": " << session::text(key, language);
  }
  if (!has_chinese_font()) GTEST_SKIP() << "built without a Chinese font";
  // The names of an implant procedure's phases are written over the picture, too.
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator("assets/implants/procedures")) {
    std::stringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    std::string line;
    for (++files; std::getline(text, line);) EXPECT_TRUE(display::can_write(line)) << line;
  }
  EXPECT_GT(files, 0);
}

TEST(HudTexts, HaveTheUnitsAndTheDecimalSignOfTheLanguage) {
  EXPECT_EQ(display::spindle_text(299.6, hud_words(Language::kEnglish)), "300 krpm");
  EXPECT_EQ(display::spindle_text(0.0149), "10 rpm");
  EXPECT_EQ(display::spindle_text(300, hud_words(Language::kGerman)), "300.000 U/min");
  EXPECT_EQ(display::spindle_text(0.8, hud_words(Language::kGerman)), "800 U/min");
  EXPECT_EQ(display::spindle_text(300, hud_words(Language::kChinese)), "300 千转/分");
  Writing point, comma;
  Hud hud = hud_in(Language::kGerman);
  hud.hint.clear();
  comma.write(hud, {640, 360});
  hud.words.decimal = '.';
  EXPECT_TRUE(comma.differs(hud, {640, 360})) << "1,25 N";
}

TEST(HudTexts, FitEveryPictureAndDoNotOverlapInAnyLanguageHoweverLongOrShort) {
  const display::DisplayRig mirror = display::load_rig("assets/rigs/mirror.json");
  std::vector<Hud> huds;
  for (const Language language : kLanguages)
    if (language != Language::kChinese || has_chinese_font()) huds.push_back(hud_in(language));
  Hud shortest = huds[0], longest = huds[0];
  shortest.tool = shortest.hint = "x";
  longest.tool = "Kegelstumpffräser mit runder Spitze 12.5 mm";
  longest.hint = kHint + "   Z macht den letzten Strich rückgängig   Y wiederholt ihn   " + kHint;
  huds.insert(huds.end(), {shortest, longest});
  for (std::size_t i = 0; i < 2; ++i) huds[i].warning = warning_text(Warning::kAxis, kLanguages[i]);
  for (Hud& hud : huds) {
    for (const glm::ivec2 place : {glm::ivec2(1920, 1080), {960, 1080}, {1280, 720}, {640, 480}, {1280, 1024}}) {
      for (const double least : {0.0, display::readable_letters(mirror)}) {
        SCOPED_TRACE(fmt::format("{}, {} x {}, least letters {}", hud.hint, place.x, place.y, least));
        Writing writing;
        hud.min_letters = least;
        writing.write(hud, place);
        ASSERT_EQ(writing.panels().size(), hud.warning.empty() ? 2u : 3u);
        for (std::size_t i = 0; i < writing.panels().size(); ++i)
          for (std::size_t j = 0; j < i; ++j) {
            const display::WritingBox &a = writing.panels()[i].box, &b = writing.panels()[j].box;
            EXPECT_TRUE(a.lo.y >= b.lo.y + b.size.y || b.lo.y >= a.lo.y + a.size.y);
          }
        for (const Writing::Panel& panel : writing.panels()) {
          EXPECT_GE(panel.box.lo.x, 0);
          EXPECT_LE(panel.box.lo.x + panel.box.size.x, place.x);
        }
      }
    }
  }
}

TEST(HudTexts, AHintWiderThanThePictureBreaksBetweenWordsOrChineseCharactersAndLosesNone) {
  for (const Language language : {Language::kEnglish, Language::kChinese}) {
    if (language == Language::kChinese && !has_chinese_font()) continue;
    SCOPED_TRACE(session::tag_of(language));
    Hud hud = hud_in(language);
    hud.tool.assign(1, 'x');
    hud.hint = language == Language::kEnglish ? kHint : hud_text(Language::kChinese, "stuck", "12");
    if (language == Language::kChinese) hud.min_letters = 0.1;
    Writing wide, narrow;
    wide.write(hud, {1920, 720});
    narrow.write(hud, {480, 720});
    ASSERT_EQ(wide.panels().size(), 2u);
    ASSERT_EQ(narrow.panels().size(), 2u);
    const Writing::Panel &one_line = wide.panels()[1], &broken = narrow.panels()[1];
    EXPECT_LE(broken.box.lo.x + broken.box.size.x, 480);
    EXPECT_GE(broken.box.lo.x, 0);
    EXPECT_GT(broken.box.size.y, 2 * one_line.box.size.y);
    EXPECT_NEAR(letters(broken), letters(one_line), 0.04 * letters(one_line));
  }
}

TEST(HudTexts, NameTheQualityLevelAndOneImprovementInEveryLanguage) {
  EXPECT_EQ(quality_text("fast", Remedy::kNone, Language::kEnglish), "picture: fast");
  EXPECT_EQ(quality_text("fast", Remedy::kGraphicsCard, Language::kEnglish),
            "picture: fast. A graphics card would improve it.");
  for (const Language language : kLanguages)
    for (const render::Quality& level : render::kQualityLadder) {
      const std::string plain = quality_text(level.name, Remedy::kNone, language);
      EXPECT_NE(plain.find(session::text(fmt::format("op.quality.{}", level.name), language)), std::string::npos);
      std::set<std::string> texts;
      for (const Remedy remedy : {Remedy::kGraphicsCard, Remedy::kSmallerWindow, Remedy::kFasterCard}) {
        const std::string text = quality_text(level.name, remedy, language);
        EXPECT_TRUE(text.starts_with(plain)) << text;
        texts.insert(text);
      }
      EXPECT_EQ(texts.size(), 3u) << plain;
    }
}

TEST(HudTexts, LookAsApprovedInEveryLanguage) {
  constexpr glm::ivec2 kSize{960, 540};
  for (const Language language : kLanguages) {
    if (language == Language::kChinese && !has_chinese_font()) continue;
    Writing writing;
    writing.write(hud_in(language), kSize);
    render::Picture picture{kSize, std::vector<std::uint8_t>(std::size_t{4} * kSize.x * kSize.y, 90)};
    for (std::size_t i = 3; i < picture.rgba.size(); i += 4) picture.rgba[i] = 255;
    for (const Writing::Panel& panel : writing.panels())
      Writing::lay_over(panel, picture.rgba.data(), std::size_t{4} * kSize.x, {0, 0}, false);
    std::string message;
    const std::string name = fmt::format("hud_{}", session::tag_of(language).substr(0, 2));
    EXPECT_TRUE(matches_golden(picture, name, 6, 60, message)) << message;
  }
}

}  // namespace
}  // namespace typodont::test
