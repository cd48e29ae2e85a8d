#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/base64.h"
#include "engine/base/error.h"
#include "engine/session/film.h"
#include "engine/session/page/plot.h"
#include "engine/session/place.h"
#include "engine/session/recorder.h"
#include "engine/session/report.h"
#include "engine/session/session_data.h"
#include "tests/support/cavity_fixture.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;
using testing::HasSubstr;
using testing::Not;
using Report = FolderTest;
using LearningCurve = FolderTest;

const std::vector<std::uint8_t> kPng = [] {
  std::vector<std::uint8_t> png(64, 7);
  const std::uint8_t signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  std::copy(std::begin(signature), std::end(signature), png.begin());
  return png;
}();

/// Records random ticks of a session in which `caries_left` (m³) of 10 mm³ of caries are left.
SessionReader record(const std::filesystem::path& file, std::size_t ticks, const std::string& note = "a note",
                     double caries_left = 2.5e-9, const std::string& date = some_header().date) {
  SessionHeader header = some_header();
  header.date = date;
  header.volumes_before[3] = 10e-9;
  {
    SessionWriter writer(file, header);
    writer.append(random_ticks(ticks, 1));
    writer.event(1000, EventKind::kNote, note);
    SessionResult result;
    result.has_volumes = true;
    result.volumes_after = header.volumes_before;
    result.volumes_after[3] = caries_left;
    result.pictures = {{"after", "", kPng}, {"before", "", kPng}};
    EXPECT_TRUE(writer.finish(result));
  }
  return SessionReader(file);
}

ReportOptions in_language(Language language) {
  ReportOptions options;
  options.language = language;
  return options;
}

/// Records random ticks and what `fill` appends to them.
SessionReader recorded(const std::filesystem::path& file, const SessionHeader& header, std::size_t ticks,
                       const std::function<void(SessionWriter&)>& fill = {}) {
  {
    SessionWriter writer(file, header);
    if (ticks > 0) writer.append(random_ticks(ticks, 1));
    if (fill) fill(writer);
    EXPECT_TRUE(writer.finish({}));
  }
  return SessionReader(file);
}

TEST_F(Report, ShowsFrameTimingOnlyIfThereWasAPicture) {
  SessionHeader header = some_header();
  header.streams.push_back({"picture",
                            {{"period_s", "s"},
                             {"record_s", "s"},
                             {"gpu_s", "s"},
                             {"motion_to_photon_s", "s"},
                             {"redrawn", ""},
                             {"quality_step", ""}}});
  const SessionReader session = recorded(folder / "s.h5", header, 20, [&](SessionWriter& writer) {
    for (int i = 0; i < 101; ++i) {
      const double ms = (1 + 0.1 * i) * 1e-3;
      writer.append(header.streams.size() - 1, i * 16'000'000,
                    std::array<double, 6>{16e-3, 1e-3, ms, 2 * ms, 0.25, i < 50 ? 1.0 : 3.0});
    }
  });
  const std::string html = report_html(session);
  EXPECT_THAT(html,
              HasSubstr("101 frames were drawn because something had moved; on average 25 % of a frame was redrawn; "
                        "quality between steps 2 and 4 (1: best)."));
  EXPECT_THAT(html, HasSubstr("<td>6.00\u00a0ms</td><td>10.9\u00a0ms</td><td>11.0\u00a0ms</td>"));  // the GPU's time
  EXPECT_THAT(html, HasSubstr("<td>12.0\u00a0ms</td><td>21.8\u00a0ms</td><td>22.0\u00a0ms</td>"));  // hand to screen
  EXPECT_THAT(report_html(session, in_language(Language::kGerman)), HasSubstr("Bilder auf dem Schirm"));
  EXPECT_THAT(report_html(recorded(folder / "none.h5", some_header(), 20)), Not(HasSubstr("Frames of the picture")));
}

TEST_F(Report, ShowsHeadsetTimingOnlyIfThereWasAHeadset) {
  SessionHeader header = some_header();
  header.streams.push_back({"headset",
                            {{"drawn", ""},
                             {"missed", ""},
                             {"pose_to_submit_s", "s"},
                             {"margin_s", "s"},
                             {"position_error_m", "m"},
                             {"angle_error_rad", "rad"}}});
  const SessionReader session = recorded(folder / "s.h5", header, 20, [&](SessionWriter& writer) {
    for (int i = 0; i < 101; ++i) {
      // Every fourth frame was not drawn, every tenth frame missed a refresh, and one could not be judged.
      const double nan = std::nan(""), ms = (1 + 0.1 * i) * 1e-3;
      const std::array<double, 6> row{i % 4 ? 1.0 : 0.0, i % 10 ? 0.0 : 1.0, ms,
                                      12e-3 - ms,        i ? 0.5e-3 : nan,   0.00349065850};
      writer.append(header.streams.size() - 1, i * 11'000'000, row);
    }
  });
  const std::string html = report_html(session);
  EXPECT_THAT(html, HasSubstr("Frames in the headset"));
  EXPECT_THAT(html, HasSubstr("101 frames, 75 of them with a picture; 11 pictures of the display were missed."));
  EXPECT_THAT(html, HasSubstr("<td>6.00\u00a0ms</td><td>10.9\u00a0ms</td><td>11.0\u00a0ms</td>"));  // pose to submit
  EXPECT_THAT(html,
              HasSubstr("<td>6.00\u00a0ms</td><td>1.10\u00a0ms</td><td>1.00\u00a0ms</td>"));  // least margin is worst
  EXPECT_THAT(html, HasSubstr("<td>0.500\u00a0mm</td>"));
  EXPECT_THAT(html, HasSubstr("<td>0.200\u00a0°</td>"));
  EXPECT_THAT(report_html(session, in_language(Language::kGerman)), HasSubstr("Bilder im Headset"));
  EXPECT_THAT(report_html(recorded(folder / "none.h5", some_header(), 20)), Not(HasSubstr("Frames in the headset")));
}

TEST(Catalogue, EveryTextExistsInEveryLanguageWithTheSamePlaceholders) {
  const auto gaps = [](std::string_view s) {
    int n = 0;
    for (std::size_t i = 0; (i = s.find("{}", i)) != std::string_view::npos; ++i) ++n;
    return n;
  };
  const std::vector<std::string_view> keys = catalogue_keys();
  std::size_t lines = 0;  // a key that stands twice has one text only
  for (const char* part : {"report", "operator", "hud"}) {
    std::ifstream file(fmt::format("engine/session/texts/{}.json", part));
    for (std::string line; std::getline(file, line);) lines += line.starts_with('"');
  }
  EXPECT_EQ(lines, keys.size());
  for (const std::string_view key : keys) {
    for (const Language language : {Language::kEnglish, Language::kGerman, Language::kChinese}) {
      EXPECT_FALSE(text(key, language).empty()) << key;
      EXPECT_EQ(gaps(text(key, language)), gaps(text(key, Language::kEnglish))) << key;
    }
  }
}

TEST(Catalogue, NamesEveryTissueFaultEventAndScore) {
  for (int i = 0; i < kTissueCount; ++i) {
    EXPECT_TRUE(has_text("tissue." + std::string(name_of(static_cast<Tissue>(i))))) << i;
  }
  for (const FaultName& fault : fault_names()) EXPECT_TRUE(has_text("fault." + fault.name)) << fault.name;
  for (int i = 0; i < kEventKindCount; ++i) {
    EXPECT_TRUE(has_text("event." + std::string(name_of(static_cast<EventKind>(i))))) << i;
  }
  for (const auto& [event, name] : kSafetyEventNames) EXPECT_TRUE(has_text("safety." + std::string(name))) << name;
  for (const std::string& name : known_score_names()) EXPECT_TRUE(has_text("score." + name)) << name;
  ScoreInput in;
  for (const ScoreRule& rule : default_rules(in)) EXPECT_TRUE(has_text(rule.source)) << rule.source;
}

TEST(Catalogue, LanguagesAreKnownByTheirTags) {
  EXPECT_EQ(language_named("de_AT.UTF-8"), Language::kGerman);
  EXPECT_EQ(language_named("zh_CN.UTF-8"), Language::kChinese);
  EXPECT_EQ(language_named("en"), Language::kEnglish);
  EXPECT_EQ(language_named("C.UTF-8"), Language::kEnglish);
  EXPECT_FALSE(language_named("tlh"));
}

TEST_F(Report, SaysWhatTheSessionHolds) {
  const SessionReader session = record(folder / "s.h5", 3000);
  const std::string html = report_html(session);
  EXPECT_THAT(html, HasSubstr("Zähne, 牙齿"));                  // the scene
  EXPECT_THAT(html, HasSubstr("2.50\u00a0mm³ (25.0\u00a0%)"));  // residual caries
  EXPECT_THAT(html, HasSubstr("round_014"));
  EXPECT_THAT(html, HasSubstr("18364758544493064720"));  // a seed, in full
  EXPECT_THAT(html, HasSubstr("fnv1a64:0123456789abcdef"));
  EXPECT_LT(html.find("Picture of the tissue: Before"), html.find("Picture of the tissue: After"));
}

/// A tetrahedron whose points deviate from the ideal by -0.5 to 0.5 mm.
ResultModel some_model() {
  ResultModel model;
  const glm::vec3 p[4] = {{0, 0, 0}, {1e-3f, 0, 0}, {0, 1e-3f, 0}, {0, 0, 1e-3f}};
  const float off[4] = {-0.5e-3f, 0, 0.25e-3f, 0.5e-3f};
  for (int k = 0; k < 4; ++k)
    model.vertices.push_back({p[k], glm::normalize(p[k] - glm::vec3(2e-4f)), Tissue::kEnamel, off[k]});
  model.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return model;
}

ReportOptions with_result() {
  ReportOptions options;
  options.result = options.ideal = some_model();
  Preparation p = a_block();
  p.after = without(tapered_box({1e-3, 0.8e-3}, 1.6e-3, 0));
  p.ideal = without(tapered_box({1e-3, 0.8e-3}, 1.3e-3, 0));
  options.input.emplace();
  options.input->before[2] = options.input->after[2] = 1e-7;
  options.input->cavity = measure_cavity(p);
  options.score = score(*options.input, default_rules(*options.input));
  options.preparation = p;
  return options;
}

TEST_F(Report, StatesLoopTimingPermissionsMotorHeatAndHashesOnAPageOfTheirOwn) {
  const SessionReader session =
      recorded(folder / "s.h5", some_header(), 500, [](SessionWriter& writer) { writer.loop(some_loop()); });
  const std::string html = report_html(session, with_result());
  EXPECT_THAT(
      html,
      HasSubstr("60000 ticks; 1 of them ended after the next sample was due (0.0017 %). Longest tick at 41.00 s"));
  EXPECT_THAT(html, HasSubstr("<td>1700 µs</td></tr>"));
  EXPECT_THAT(html, HasSubstr("Histogram of the jitter of 59999 wake-ups"));
  EXPECT_THAT(html, HasSubstr("<dt>Real-time priority</dt><dd>granted</dd>"));
  EXPECT_THAT(html, HasSubstr("<dt>Reserved processor core</dt><dd>not granted"));
  EXPECT_THAT(html, HasSubstr("93 % of their limit"));
  EXPECT_THAT(html, HasSubstr("force limited because of warm motors; the servo stopped writing: no force"));
  EXPECT_THAT(report_html(session, in_language(Language::kGerman)),
              HasSubstr("<dt>Echtzeitpriorität</dt><dd>gewährt</dd>"));
  // The report of a session that did not run live does not contain this section.
  EXPECT_THAT(report_html(recorded(folder / "none.h5", some_header(), 500)), Not(HasSubstr("Real-time priority")));
  const std::size_t page = html.find("<div id=\"technical\"");
  ASSERT_NE(page, std::string::npos);
  for (const char* text : {"id=\"timing\"", "id=\"faults\"", "id=\"details\"", "fnv1a64:", "Real-time priority"}) {
    EXPECT_GT(html.find(text), page) << text;
    EXPECT_NE(html.find(text), std::string::npos) << text;
  }
  EXPECT_LT(html.find("id=\"items\""), page);
  EXPECT_THAT(html, HasSubstr("<a href=\"#technical\">"));
}

TEST_F(Report, IsInTheLanguageAskedForWithItsDecimalComma) {
  const SessionReader session = record(folder / "s.h5", 2000);
  const std::string german = report_html(session, in_language(Language::kGerman));
  EXPECT_THAT(german, HasSubstr("<html lang=\"de\">"));
  EXPECT_THAT(german, HasSubstr("Restkaries"));
  EXPECT_THAT(german, HasSubstr("2,50\u00a0mm³ (25,0\u00a0%)"));
  const std::string chinese = report_html(session, in_language(Language::kChinese));
  EXPECT_THAT(chinese, HasSubstr("<html lang=\"zh-Hans\">"));
  EXPECT_THAT(chinese, HasSubstr("残余龋坏"));
}

TEST_F(Report, NamesToolsAndFaultsOfItsEventsInTheReadersLanguage) {
  const SessionReader session = recorded(folder / "s.h5", some_header(), 100, [](SessionWriter& writer) {
    writer.event(1000, EventKind::kTool, "round_012");
    writer.event(2000, EventKind::kFault, "stale_patch");
  });
  const std::string german = report_html(session, in_language(Language::kGerman));
  EXPECT_THAT(german, HasSubstr("Werkzeug: Rundbohrer (round_012)"));
  EXPECT_THAT(german, HasSubstr("Störung: Gewebe über 20 ms zu spät aktualisiert"));
}

TEST_F(Report, CountsFaultsAsEventsWithTheirTotalTimeAndKindAndIsSilentWithoutFaults) {
  const auto page = [&](const std::function<std::uint32_t(std::size_t tick)>& faults, Language language) {
    SessionWriter writer(folder / "s.h5", some_header());
    std::vector<ServoTick> ticks = random_ticks(4000, 1);
    for (std::size_t i = 0; i < ticks.size(); ++i) ticks[i].faults = faults(i);
    writer.append(ticks);
    EXPECT_TRUE(writer.finish({}));
    return report_html(SessionReader(folder / "s.h5"), in_language(language));
  };
  // The limit is left for 50 ms, then for two seconds; between, the emergency key stops the session.
  const auto twice = [](std::size_t i) {
    const bool limited = (i >= 1000 && i < 1100) || (i >= 1150 && i < 1200) || (i >= 3200 && i < 3250);
    return bits(limited ? Fault::kForceLimit : i >= 2000 && i < 2500 ? Fault::kHeld : Fault::kNone);
  };
  const std::string english = page(twice, Language::kEnglish);
  EXPECT_THAT(english, HasSubstr("<dt>Faults</dt><dd>2 times, 0.200\u00a0s in all</dd>"));
  EXPECT_THAT(english, HasSubstr(">Force reduced to the device's limit: 2 times, 0.200\u00a0s in all</dd>"));
  EXPECT_THAT(english, Not(HasSubstr("class=\"kind\">Stopped")));
  EXPECT_THAT(english, HasSubstr("<td>once, 0.500\u00a0s</td>")) << "the table of timing names the stop";
  EXPECT_THAT(page(twice, Language::kGerman), HasSubstr("<dd>2-mal, insgesamt 0,200\u00a0s</dd>"));
  const auto once = [](std::size_t i) { return i == 7 ? bits(Fault::kOverrun) : 0; };
  EXPECT_THAT(page(once, Language::kEnglish), HasSubstr("<dt>Faults</dt><dd>once, 0.001\u00a0s</dd>"));
  EXPECT_THAT(page([](std::size_t) { return 0u; }, Language::kEnglish), Not(HasSubstr("<dt>Faults</dt>")));
}

/// Sets the time zone of this process.
struct TimeZone {
  explicit TimeZone(const char* zone) {
    setenv("TZ", zone, 1);
    tzset();
  }
  ~TimeZone() {
    known ? setenv("TZ", before.c_str(), 1) : unsetenv("TZ");
    tzset();
  }
  const bool known = std::getenv("TZ") != nullptr;
  const std::string before = known ? std::getenv("TZ") : "";
};

TEST_F(Report, StatesTimesOfThisMachinesTimeZoneWhichItNamesOnce) {
  const TimeZone berlin("CET-1CEST,M3.5.0,M10.5.0/3");
  const SessionReader session = recorded(folder / "s.h5", some_header(), 10);
  ReportOptions options;
  options.remarks = {{"Teacher", "2025-07-01T22:30:00Z", "Good", std::nullopt}};
  const std::string html = report_html(session, options);
  EXPECT_THAT(html, HasSubstr("<time datetime=\"2025-01-02T03:04:05Z\">2025-01-02 04:04 (UTC+01:00)</time>"));
  EXPECT_THAT(html, HasSubstr("Teacher, 2025-07-02 00:30</p>"));
  EXPECT_EQ(html.find("UTC"), html.rfind("UTC"));
  std::vector<SessionSummary> sessions(2);
  sessions[0].file = "winter.h5", sessions[0].date = "2025-01-01T10:00:00Z";
  sessions[1].file = "summer.h5", sessions[1].date = "2025-07-01T10:00:00Z";
  const std::string curve = learning_curve_html(sessions, Language::kEnglish);
  EXPECT_THAT(curve, HasSubstr("Times: UTC+01:00, UTC+02:00</p>"));
  EXPECT_THAT(curve, HasSubstr("<td>2025-01-01 11:00</td>"));
  EXPECT_THAT(curve, HasSubstr("<td>2025-07-01 12:00</td>"));
}

TEST(LocalTime, OfATextThatIsNoDateOfAFileIsEmpty) {
  for (const char* text : {"", "2025-01-02", "2025-01-02T03:04:05+02:00", "2025-13-02T03:04:05Z", "yesterday"})
    EXPECT_FALSE(local_time(text)) << text;
  const TimeZone newfoundland("NST3:30");
  ASSERT_TRUE(local_time("2025-01-02T03:04:05Z"));
  EXPECT_EQ(local_time("2025-01-02T03:04:05Z")->text, "2025-01-01 23:34");
  EXPECT_EQ(local_time("2025-01-02T03:04:05Z")->zone, "UTC-03:30");
}

TEST_F(Report, RoundsTheSumOfTheItemsTheDoneShareAndTheScoreDownAlike) {
  record(folder / "s.h5", 500);
  ReportOptions options = with_result();
  Score& s = *options.score;
  s.items.resize(2);
  for (ScoreItem& item : s.items) item.full = 50, item.points = 48.17, item.critical = false;
  s.completion = 0.9985;
  s.points = s.completion * 96.34;
  const std::string html = report_html(SessionReader(folder / "s.h5"), options);
  EXPECT_THAT(html, HasSubstr("<p class=\"big\">96.1<small> / 100</small></p>"));
  for (const char* cell : {"48.1 / 50.0<", "96.3 / 100</td>", "× 99.8 %</td>", "96.1 / 100</td>"})
    EXPECT_THAT(html, HasSubstr(std::string("<td class=\"points\">") + cell));
  EXPECT_THAT(html, HasSubstr("<th scope=\"col\">Item</th><th scope=\"col\">Points</th>"));
  s.points = 96.34, s.completion = 1;
  EXPECT_THAT(report_html(SessionReader(folder / "s.h5"), options), HasSubstr("× 100 %</td>"));
}

TEST_F(Report, TextFromTheSessionCannotBecomeMarkup) {
  record(folder / "s.h5", 100, "<img src=x onerror=\"alert('1')\"> & more");
  const std::string html = report_html(SessionReader(folder / "s.h5"));
  EXPECT_THAT(html, Not(HasSubstr("<img src=x")));
  EXPECT_THAT(html, HasSubstr("&lt;img src=x onerror=&quot;alert(&#39;1&#39;)&quot;&gt; &amp; more"));
}

TEST_F(Report, StatesThatASessionIsTruncatedOrEmpty) {
  { SessionWriter(folder / "s.h5", some_header()).append(random_ticks(10, 1)); }
  EXPECT_THAT(report_html(SessionReader(folder / "s.h5")), HasSubstr("cut off before its end"));
  EXPECT_THAT(report_html(recorded(folder / "e.h5", some_header(), 0)), HasSubstr("Nothing was recorded"));
}

TEST_F(Report, StatesWhatIsMissingFromTheFile) {
  SessionWriter writer(folder / "s.h5", some_header());
  writer.count_ring_losses(12, 3, 7);
  ASSERT_FALSE(writer.finish({}));
  EXPECT_THAT(writer.status().message, HasSubstr("12 ticks, 3 cuts, 7 other entries"));
  const SessionReader session(folder / "s.h5");
  EXPECT_FALSE(session.truncated());
  EXPECT_THAT(report_html(session),
              HasSubstr("12 ticks, 3 cuts, 0 pictures and 7 other entries did not reach the file."));
}

TEST_F(Report, AMistakeInTheScenesRulesIsAnErrorThatNamesTheSession) {
  SessionHeader header = some_header();
  header.scene_json = R"({"score": {"rules": 3}})";
  EXPECT_THAT(test::refusal([&] { report_html(recorded(folder / "s.h5", header, 0)); }),
              HasSubstr("s.h5: scene: line 1, \"score.rules\": found 3"));
}

TEST_F(LearningCurve, ShowsEverySessionOfASceneByDateWithItsScores) {
  std::vector<SessionSummary> sessions;
  for (const char* date : {"2025-03-01T10:00:00Z", "2025-01-01T10:00:00Z", "2025-02-01T10:00:00Z"}) {
    const auto file = folder / (std::string(date).substr(5, 2) + ".h5");
    sessions.push_back(summarize(record(file, 600, "", 2e-9 * static_cast<double>(sessions.size() + 1), date)));
  }
  const std::string html = learning_curve_html(sessions, Language::kEnglish);
  EXPECT_THAT(html, HasSubstr("Learning curve"));
  EXPECT_THAT(html, HasSubstr("Zähne, 牙齿"));
  EXPECT_LT(html.find("01.h5"), html.find("02.h5"));
  EXPECT_LT(html.find("02.h5"), html.find("03.h5"));
  // By date, the first session is the one recorded second: 4 of 10 mm³ remain. The last by date is the one recorded
  // first: 2 of 10 mm³ remain.
  EXPECT_THAT(html, HasSubstr("Residual caries, share, session by session: first 40.0\u00a0%, last 20.0\u00a0%."));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
}

TEST_F(LearningCurve, NamesAnExerciseInTheReadersLanguage) {
  SessionHeader header = some_header();
  header.scene_json =
      R"({"name": "plain", "task": {"title": {"en": "Class I cavity", "de": "Kavität der Klasse I", "zh": "I 类洞"}, "goal": "g"}})";
  const std::vector<SessionSummary> sessions{summarize(recorded(folder / "a.h5", header, 0))};
  EXPECT_THAT(learning_curve_html(sessions, Language::kEnglish), HasSubstr(">Class I cavity</h2>"));
  EXPECT_THAT(learning_curve_html(sessions, Language::kGerman), HasSubstr(">Kavität der Klasse I</h2>"));
  EXPECT_THAT(learning_curve_html(sessions, Language::kChinese), HasSubstr(">I 类洞</h2>"));
}

TEST(ReportPicture, ShowsTheModelAtItsPlaceAndTheDifferenceInColours) {
  const auto png = draw_model(some_model(), {{0, 0, -1}, {0, 1, 0}}, {64, 64}, true);
  ASSERT_GT(png.size(), 100u);
  EXPECT_EQ(png[1], 'P');
  EXPECT_NE(png, draw_model(some_model(), {{0, 0, -1}, {0, 1, 0}}, {64, 64}, false));
  EXPECT_NE(png, draw_model(some_model(), {{1, 0, 0}, {0, 0, 1}}, {64, 64}, true));
  EXPECT_EQ(png, draw_model(some_model(), {{0, 0, -1}, {0, 1, 0}}, {64, 64}, true));
}

TEST_F(Report, ContainsPicturesATurnableViewSectionsAndTheWorstPlaces) {
  record(folder / "s.h5", 500);
  const std::string html = report_html(SessionReader(folder / "s.h5"), with_result());
  EXPECT_THAT(html, HasSubstr("id=\"viewer\" hidden"));
  EXPECT_THAT(html, HasSubstr("<noscript>"));
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
  EXPECT_THAT(html, HasSubstr("alt=\"Picture of the tissue: Difference from the ideal: From the side\""));
  EXPECT_THAT(html, HasSubstr("Cut too deep: greatest depth 0.300"));
  EXPECT_THAT(html, HasSubstr("<svg class=\"section\""));
  EXPECT_THAT(html, Not(HasSubstr("http:")));
  EXPECT_THAT(html, Not(HasSubstr("https:")));
  EXPECT_THAT(html, Not(HasSubstr(">nan")));
}

TEST_F(Report, ShowsAMissedPassMarkInRedWithItsSourceAndAMetOneNot) {
  record(folder / "s.h5", 500);
  ReportOptions options = with_result();
  Score& s = *options.score;
  const auto page = [&](double points) {
    s.points = points;
    return report_html(SessionReader(folder / "s.h5"), options);
  };
  const std::string missed = page(74.96), met = page(75);
  EXPECT_THAT(missed, HasSubstr("<p class=\"big missed\">74.9<small> / 100</small></p>"));
  EXPECT_THAT(missed, HasSubstr("Not passed"));
  EXPECT_THAT(missed, HasSubstr("Pass mark: 75 (75 of 100, as in the ADEX licensure examination"));
  EXPECT_THAT(met, HasSubstr("<p class=\"big\">75.0<small> / 100</small></p>"));
  EXPECT_THAT(met, Not(HasSubstr("Not passed")));
  s.items.front().critical = true;
  EXPECT_THAT(page(90), testing::AllOf(HasSubstr("Not passed"), HasSubstr("Critical error: ")));
}

TEST_F(Report, NamesTheWorstPlacesInDentalTermsIfTheSceneGivesTheOrientation) {
  SessionHeader header = some_header();
  header.scene_json = R"({"name": "n", "tooth": {"mesial": [1, 0, 0], "buccal": [0, 1, 0]}})";
  const SessionReader session = recorded(folder / "s.h5", header, 100);
  ReportOptions options = with_result();
  Preparation& p = *options.preparation;
  options.input->cavity->over = {0.3e-3, kMiddle + dvec3(0.9e-3, 0, -1.6e-3)};
  const auto page = [&](Language language) {
    options.language = language;
    return report_html(session, options);
  };
  EXPECT_THAT(page(Language::kEnglish), HasSubstr("Cut too deep: greatest depth 0.300\u00a0mm, mesial floor."));
  EXPECT_THAT(page(Language::kGerman), HasSubstr("größte Tiefe 0,300\u00a0mm, Boden, mesial."));
  EXPECT_THAT(page(Language::kChinese), HasSubstr("近中洞底"));
  EXPECT_EQ(place_name(p, {}, kMiddle + dvec3(0, -0.8e-3, -0.2e-3)).side, "lingual");
  EXPECT_THAT(page(Language::kEnglish), HasSubstr("Difference from the ideal: Lingual view"));
  EXPECT_THAT(page(Language::kEnglish), HasSubstr("Difference from the ideal: Mesial view"));
  EXPECT_THAT(page(Language::kEnglish), HasSubstr(">Occlusal view</button>"));
  EXPECT_THAT(page(Language::kEnglish),
              HasSubstr(">distal</text><text x=\"394\" y=\"14\" text-anchor=\"end\">mesial</text>"));
  EXPECT_THAT(page(Language::kGerman),
              HasSubstr(">lingual</text><text x=\"394\" y=\"14\" text-anchor=\"end\">bukkal</text>"));
}

/// Returns the name of the place at (x, y, -deep) from the middle of the block's top, m.
std::string place_words(const Preparation& work, const ToothSides& tooth, double x, double y, double deep) {
  const PlaceName name = place_name(work, tooth, kMiddle + dvec3(x, y, -deep));
  return fmt::format("{} {} {}", name.part, name.side, name.third);
}

TEST(Places, APlaceInACavityIsNamedByPartSideAndThird) {
  // A square cavity, and the stump of a crown: floor and walls of the one, shoulder, axial walls and top of the other.
  Preparation cavity = a_block();
  cavity.after = cavity.ideal = without(tapered_box({1e-3, 1e-3}, 1.5e-3, 0));
  const ToothSides tooth{{0, 1, 0}, {-1, 0, 0}, {}};  // turned a quarter
  const auto wall = [&](double x, double y, double deep) { return place_words(cavity, tooth, x, y, deep); };
  EXPECT_EQ(wall(0, 1e-3, 0.2e-3), "wall mesial occlusal");
  EXPECT_EQ(wall(0, 1.2e-3, 0.2e-3), "margin mesial ");  // cut too far
  EXPECT_EQ(wall(0, -1e-3, 0.75e-3), "wall distal middle");
  EXPECT_EQ(wall(-1e-3, 0, 1.2e-3), "wall buccal cervical");
  EXPECT_EQ(wall(1e-3, 0, 0.75e-3), "wall lingual middle");
  EXPECT_EQ(wall(-1e-3, 0.9e-3, 0.75e-3), "wall mesiobuccal middle");
  EXPECT_EQ(wall(1e-3, -0.9e-3, 0.75e-3), "wall distolingual middle");
  EXPECT_EQ(wall(0, 0, 1.5e-3), "floor central ");
  EXPECT_EQ(wall(0.7e-3, 0.7e-3, 1.5e-3), "floor mesiolingual ");
  Preparation crown = a_block();
  crown.after = crown.ideal = sampled(kBlock, [](const dvec3& p) {
    const double stump = std::max(
                     {std::abs(p.x - kMiddle.x) - 1e-3, std::abs(p.y - kMiddle.y) - 1e-3, p.z - (kTop - 0.5e-3)}),
                 outside = std::max({std::abs(p.x - kMiddle.x) - 2e-3, std::abs(p.y - kMiddle.y) - 2e-3});
    const double prepared = std::min(stump, std::max(p.z - (kTop - 1.5e-3), -1.0));
    return outside < 0 ? std::max(block(p), prepared) : block(p);
  });
  const auto on_crown = [&](double x, double y, double deep) { return place_words(crown, tooth, x, y, deep); };
  EXPECT_EQ(on_crown(0, 0, 0.5e-3), "occlusal central ");
  EXPECT_EQ(on_crown(0, 1e-3, 0.8e-3), "axial mesial middle");
  EXPECT_EQ(on_crown(0, -1.5e-3, 1.5e-3), "shoulder distal ");
}

TEST(Places, OnAToothThatLiesAPlaceIsNamedOcclusalOrCervical) {
  // Lower left: mesial x, buccal up (the task's axis), the crown to -y.
  const ToothSides tooth{{1, 0, 0}, {0, 0, 1}, dvec3(0, -1, 0)};
  Preparation work = a_block();
  work.after = work.ideal = without(tapered_box({1e-3, 1e-3}, 1.5e-3, 0));
  const auto place = [&](double x, double y, double deep) { return place_words(work, tooth, x, y, deep); };
  EXPECT_EQ(place(0, -1e-3, 0.75e-3), "wall occlusal ");
  EXPECT_EQ(place(0, 1e-3, 0.75e-3), "wall cervical ");
  EXPECT_EQ(place(0.7e-3, 0.7e-3, 1.5e-3), "floor mesiocervical ");
  EXPECT_EQ(side_seen(tooth, {0, 0, 1}, {0, 0, -1}), "buccal");
  EXPECT_EQ(side_seen(tooth, {0, 0, 1}, {0, 1, 0}), "occlusal");
  // Calculus of 0.5 mm.
  work.after = work.ideal = sampled(kBlock, [](const dvec3& p) { return std::max(block(p), p.z - (kTop - 0.5e-3)); });
  work.contour = true;
  EXPECT_EQ(place(1.5e-3, -1.5e-3, 0.5e-3), "buccal mesioocclusal ");
}

TEST(Places, TheSidesOfAToothAreReadAndMistakesNamed) {
  const auto sides = [](const std::string& tooth) {
    return tooth_sides(Json::parse(R"({"tooth": )" + tooth + "}", "scene.json"));
  };
  EXPECT_FALSE(tooth_sides(Json::parse("{}", "s")));
  const auto lean = sides(R"({"mesial": [2, 0, 0], "buccal": [0.02, 1, 0]})");
  ASSERT_TRUE(lean);
  EXPECT_NEAR(glm::dot(lean->mesial_W, lean->buccal_W), 0, 1e-12);
  EXPECT_NEAR(glm::length(lean->buccal_W), 1, 1e-12);
  EXPECT_EQ(sides(R"({"mesial": [1, 0, 0], "buccal": [0, 0, 1], "occlusal": [0, -2, 0]})")->occlusal_W,
            dvec3(0, -1, 0));
  EXPECT_THROW(sides(R"({"mesial": [1, 0, 0], "buccal": [0, 1, 0], "occlusal": [0, 1, 0]})"), Error);
  EXPECT_THROW(sides(R"({"mesial": [1, 0, 0]})"), Error);
  EXPECT_THROW(sides(R"({"mesial": [1, 0, 0], "buccal": [1, 1, 0]})"), Error);
  EXPECT_THROW(sides(R"({"mesial": [0, 0, 0], "buccal": [0, 1, 0]})"), Error);
}

TEST(Catalogue, NamesEveryShippedToolInEveryLanguage) {
  int tools = 0;
  for (const auto& entry : std::filesystem::directory_iterator("assets/tools")) {
    const std::string name = entry.path().stem().string();
    const std::string english = tool_text(name, Language::kEnglish);
    EXPECT_NE(english, tool_text(name, Language::kGerman)) << name;
    EXPECT_NE(english, tool_text(name, Language::kChinese)) << name;
    ++tools;
  }
  EXPECT_GT(tools, 40);
  EXPECT_EQ(tool_text("round_012", Language::kGerman), "Rundbohrer");
  EXPECT_EQ(tool_text("my_own-tool_7", Language::kGerman), "My own tool");
  EXPECT_EQ(tool_text("123", Language::kEnglish), "123");
}

TEST_F(Report, ComparesWithEarlierSessionsAndTheExpert) {
  record(folder / "s.h5", 500);
  ReportOptions options = with_result();
  SessionSummary earlier{"a.h5", "2025-01-01T00:00:00Z", "", "x", false, *options.score, {}};
  earlier.score.points = 0.25 * earlier.score.full;
  SessionSummary expert = earlier;
  expert.score.points = 0.9 * expert.score.full;
  options.earlier = {earlier};
  options.expert = expert;
  const std::string html = report_html(SessionReader(folder / "s.h5"), options);
  EXPECT_THAT(html, HasSubstr("Earlier sessions of this scene: 1"));
  EXPECT_THAT(html, HasSubstr("✗</span> 25.0</span></td><td>90.0</td></tr></tfoot>"));
}

TEST(ReportPicture, MustBeAPng) {
  TemporaryFolder folder;
  std::ofstream(folder / "x.png") << std::string(100, 'x');
  EXPECT_THROW(read_picture(folder / "x.png", "before"), Error);
  EXPECT_THROW(read_picture(folder / "none.png", "before"), Error);
  EXPECT_THROW(read_picture(folder.path(), "before"), Error);
  std::ofstream(folder / "good.png", std::ios::binary).write(reinterpret_cast<const char*>(kPng.data()), 64);
  EXPECT_EQ(read_picture(folder / "good.png", "before").png, kPng);
}

TEST(Plot, AxisStepsAreRoundNumbersAndBase64IsStandard) {
  EXPECT_DOUBLE_EQ(nice_step(1, 4), 0.5);
  EXPECT_DOUBLE_EQ(nice_step(0.8, 4), 0.2);
  EXPECT_DOUBLE_EQ(nice_step(41.2, 10), 5);
  EXPECT_EQ(decimals_for(0.5), 1);
  EXPECT_EQ(decimals_for(0.02), 2);
  EXPECT_EQ(decimals_for(5), 0);
  const auto encode = [](std::string_view s) { return base64(std::vector<std::uint8_t>(s.begin(), s.end())); };
  // RFC 4648, section 10.
  EXPECT_EQ(encode(""), "");
  EXPECT_EQ(encode("f"), "Zg==");
  EXPECT_EQ(encode("fo"), "Zm8=");
  EXPECT_EQ(encode("foo"), "Zm9v");
  EXPECT_EQ(encode("foobar"), "Zm9vYmFy");
}

TEST(Plot, ABandWithoutDataIsAGap) {
  Series series{{0, std::nan(""), 1}, {0.5, std::nan(""), 1}, {1, std::nan(""), 1}};
  TimePlot plot;
  const std::string svg =
      time_plot(plot, series, [](double v, int d) { return std::to_string(d) + std::to_string(v); });
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  std::size_t bands = 0;
  for (std::size_t at = 0; (at = svg.find("class=\"band\"", at)) != std::string::npos; ++at) ++bands;
  EXPECT_EQ(bands, 2u);
}

/// While this object exists, the system finds the programs of this folder only.
struct ProgramsOf {
  std::string kept = std::getenv("PATH");
  explicit ProgramsOf(const std::filesystem::path& folder) { setenv("PATH", folder.c_str(), 1); }
  ~ProgramsOf() { setenv("PATH", kept.c_str(), 1); }
};

TEST(Film, WithoutAnEncoderThereIsAMessageAndNoFile) {
  TemporaryFolder folder;
  const ProgramsOf none("/nowhere");
  FilmWriter film(folder / "f.mp4", {64, 48, 30});
  const std::vector<std::uint8_t> frame(64 * 48 * 4);
  EXPECT_FALSE(film.add(frame));
  EXPECT_FALSE(film.finish());
  EXPECT_THAT(film.message(), HasSubstr("ffmpeg is not installed"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Film, AFailingEncoderGivesAMessageAndNoFile) {
  TemporaryFolder folder;
  // Replaces an encoder and returns an error.
  std::filesystem::create_directory(folder / "bin");
  std::ofstream(folder / "bin/ffmpeg") << "#!/bin/sh\necho 'Unknown encoder' >&2\nexit 1\n";
  std::filesystem::permissions(folder / "bin/ffmpeg", std::filesystem::perms::owner_all);
  const ProgramsOf fake(folder / "bin");
  FilmWriter film(folder / "f.mp4", {640, 480, 30});
  const std::vector<std::uint8_t> frame(640 * 480 * 4);
  for (int i = 0; i < 50; ++i) film.add(frame);
  EXPECT_FALSE(film.finish());
  EXPECT_THAT(film.message(), HasSubstr("ffmpeg gave up: Unknown encoder"));
  EXPECT_FALSE(std::filesystem::exists(folder / "f.mp4"));
}

}  // namespace
}  // namespace typodont::session
