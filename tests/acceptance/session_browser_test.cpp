// The report in a real browser: its script runs and draws, dark and printed it is there too, and nothing is fetched.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/session/recorder.h"
#include "engine/session/report.h"
#include "tests/support/cavity_fixture.h"
#include "tests/support/program.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using testing::HasSubstr;
using testing::Not;

class ReportInABrowser : public testing::Test {
 protected:
  ReportInABrowser() : browser_(TYPODONT_BROWSER) {
    {
      SessionWriter writer(browser_ / "s.h5", test::some_header());
      writer.append(test::random_ticks(2000, 5));
      EXPECT_TRUE(writer.finish({}));
    }
    ReportOptions& options = options_;
    ResultModel model;
    const glm::vec3 p[4] = {{0, 0, 0}, {4e-3f, 0, 0}, {0, 4e-3f, 0}, {0, 0, 4e-3f}};
    for (int k = 0; k < 4; ++k) {
      model.vertices.push_back(
          {p[k], glm::normalize(p[k] - glm::vec3(1e-3f)), Tissue::kEnamel, 1e-4f * static_cast<float>(k)});
    }
    model.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    options.result = options.ideal = model;
    Preparation preparation = test::a_block();
    preparation.after = test::without(test::tapered_box({1e-3, 0.8e-3}, 1.6e-3, 0));
    preparation.ideal = test::without(test::tapered_box({1e-3, 0.8e-3}, 1.3e-3, 0));
    options.preparation = preparation;
    page_ = browser_.write("report.html", report_html(SessionReader(browser_ / "s.h5"), options));
  }
  typodont::test::Ran browse(const std::string& arguments) const {
    return browser_.run(fmt::format("--no-sandbox --disable-gpu --virtual-time-budget=4000 --window-size=900,2600 "
                                    "--user-data-dir={} --enable-logging=stderr {} file://{}",
                                    browser_ / "profile", arguments, page_),
                        "timeout 120");
  }
  ReportOptions options_;
  typodont::test::ProgramFolder browser_;
  std::string page_;
};

TEST_F(ReportInABrowser, DrawsTheResultWithItsScriptAndComplainsOfNothing) {
  const typodont::test::Ran ran = browse("--dump-dom");
  ASSERT_EQ(ran.status, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("data-drawn=\"difference\""));
  EXPECT_THAT(ran.out, Not(HasSubstr("id=\"viewer\" hidden")));
  EXPECT_THAT(ran.out, HasSubstr("data-mode=\"difference\" aria-pressed=\"true\""));
  EXPECT_THAT(ran.err, Not(HasSubstr("Uncaught")));
  EXPECT_THAT(ran.err, Not(HasSubstr("Refused to")));
}

TEST_F(ReportInABrowser, IsThereOnLightAndDarkScreensAndOnPaper) {
  ASSERT_EQ(browse(fmt::format("--screenshot={}", browser_ / "light.png")).status, 0);
  ASSERT_EQ(
      browse(fmt::format("--blink-settings=preferredColorScheme=0 --screenshot={}", browser_ / "dark.png")).status, 0);
  ASSERT_EQ(browse(fmt::format("--print-to-pdf={}", browser_ / "page.pdf")).status, 0);
  const std::string light = typodont::test::read_text(browser_ / "light.png"),
                    dark = typodont::test::read_text(browser_ / "dark.png");
  EXPECT_GT(light.size(), 20000u);
  EXPECT_GT(dark.size(), 20000u);
  EXPECT_NE(light, dark);
  EXPECT_TRUE(typodont::test::read_text(browser_ / "page.pdf").starts_with("%PDF"));
}

TEST_F(ReportInABrowser, IsThereForScreenReadersKeyboardsWeakEyesTelephonesAndPaper) {
  for (const Language language : {Language::kEnglish, Language::kGerman, Language::kChinese}) {
    const SessionReader session(browser_ / "s.h5");
    options_.language = language;
    options_.earlier = {summarize(session)};
    options_.expert = summarize(session);
    const std::string page = browser_.write("read.html", report_html(session, options_));
    const typodont::test::ProgramFolder python("/usr/bin/python3");
    const typodont::test::Ran ran = python.run(
        fmt::format("{} {} {} {}", TYPODONT_PAGE_CHECK, TYPODONT_BROWSER, page, tag_of(language).substr(0, 2)),
        "timeout 280");
    EXPECT_EQ(ran.status, 0) << ran.out << ran.err;
    EXPECT_THAT(ran.out, HasSubstr("looked at"));
  }
}

}  // namespace
}  // namespace typodont::session
