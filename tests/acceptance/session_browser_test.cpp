// Tests the report in a real browser: its script runs and draws, the dark and the printed version are complete, and
// nothing is loaded from the network.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <sstream>

#include "engine/base/voxels.h"
#include "engine/session/page/model_colors.h"
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
  typodont::test::Ran browse(const std::string& arguments) const { return browse(arguments, page_); }
  typodont::test::Ran browse(const std::string& arguments, const std::string& page) const {
    return browser_.run(fmt::format("--no-sandbox --disable-gpu --virtual-time-budget=4000 --window-size=900,2600 "
                                    "--user-data-dir={} --enable-logging=stderr {} file://{}",
                                    browser_ / "profile", arguments, page),
                        "timeout 120");
  }
  /// Returns what a script found in the page after the page was drawn: the text that the script writes to
  /// document.body.dataset.seen. Frames are drawn on the browser's virtual time, 16 ms apart, as its timers are: a real
  /// frame can come after all timers.
  std::string told_by(const std::string& script) const {
    std::string html = report_html(SessionReader(browser_ / "s.h5"), options_);
    html.insert(html.find("</head>"),
                "<script>window.requestAnimationFrame = f => setTimeout(() => f(performance.now()), 16);</script>");
    html.insert(html.rfind("</body>"), "<script>" + script + "</script>");
    const typodont::test::Ran ran = browse("--dump-dom", browser_.write("told.html", html));
    EXPECT_THAT(ran.err, Not(HasSubstr("Uncaught")));
    const std::string begin = "data-seen=\"";
    const std::size_t at = ran.out.find(begin);
    if (at == std::string::npos) return "";
    return ran.out.substr(at + begin.size(), ran.out.find('"', at + begin.size()) - at - begin.size());
  }
  ReportOptions options_;
  typodont::test::ProgramFolder browser_;
  std::string page_;
};

TEST_F(ReportInABrowser, TheScriptDrawsTheResultWithoutConsoleErrors) {
  const typodont::test::Ran ran = expect_ok(browse("--dump-dom"));
  EXPECT_THAT(ran.out, HasSubstr("data-drawn=\"difference\""));
  EXPECT_THAT(ran.out, Not(HasSubstr("id=\"viewer\" hidden")));
  EXPECT_THAT(ran.out, HasSubstr("data-mode=\"difference\" aria-pressed=\"true\""));
  EXPECT_THAT(ran.err, Not(HasSubstr("Uncaught")));
  EXPECT_THAT(ran.err, Not(HasSubstr("Refused to")));
}

/// Returns a box about the origin with this half size. `tissue_at` returns the tissue at a position in it.
template <class TissueAt>
ResultModel box(const glm::vec3& half, TissueAt tissue_at) {
  ResultModel model;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      const auto first = static_cast<std::uint32_t>(model.vertices.size());
      for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
        glm::vec3 p, n(0);
        p[axis] = side * half[axis];
        p[(axis + 1) % 3] = static_cast<float>(a) * half[(axis + 1) % 3];
        p[(axis + 2) % 3] = static_cast<float>(b) * half[(axis + 2) % 3];
        n[axis] = side;
        model.vertices.push_back({p, n, Tissue::kEnamel, 0});
      }
      if (side > 0)
        model.triangles.insert(model.triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
      else
        model.triangles.insert(model.triangles.end(), {{first, first + 2, first + 1}, {first, first + 3, first + 2}});
    }
  model.labels.frame = {dvec3(-half), 0.2e-3};
  model.labels.size = glm::ivec3(2.0f * half / 0.2e-3f + 1.5f);
  for_each_voxel(model.labels.size, [&](int x, int y, int z) {
    model.labels.tissue.push_back(tissue_at(model.labels.frame.to_world(dvec3(x, y, z))));
  });
  return model;
}

TEST_F(ReportInABrowser, TheCutFaceShowsTheTissuesInside) {
  options_.result = box(glm::vec3(2e-3f), [](const dvec3& p) { return p.x < 0 ? Tissue::kDentin : Tissue::kPulp; });
  options_.ideal.reset();
  options_.preparation.reset();
  // Cuts the model in the middle and looks at it from the front. Reads the colours left and right of the middle.
  const std::string seen = told_by(
      "{const v = document.getElementById('viewer'), c = v.querySelector('canvas'), s = v.querySelector('[name=cut]');"
      "v.querySelector('[data-look=front]').click(); s.value = 50; s.dispatchEvent(new Event('input'));"
      "setTimeout(() => { const p = k => [...c.getContext('2d').getImageData(c.width * k, c.height / 2, 1, 1).data];"
      "document.body.dataset.seen = [...p(0.45), ...p(0.55)].join(' '); }, 500);}");
  std::array<double, 8> c{};
  std::istringstream numbers(seen);
  for (double& v : c) numbers >> v;
  ASSERT_TRUE(numbers) << seen;
  const auto& dentin = kTissueColors[static_cast<std::size_t>(Tissue::kDentin)];
  const auto& pulp = kTissueColors[static_cast<std::size_t>(Tissue::kPulp)];
  EXPECT_NEAR(c[1] / c[0], static_cast<double>(dentin[1]) / dentin[0], 0.02) << seen;
  EXPECT_NEAR(c[5] / c[4], static_cast<double>(pulp[1]) / pulp[0], 0.02) << seen;
  EXPECT_GT(c[0], 0.4 * dentin[0]) << "dark: " << seen;
}

TEST_F(ReportInABrowser, AHorizontalDragTurnsAboutTheVerticalAxis) {
  options_.result = box({0.1e-3f, 0.1e-3f, 3e-3f}, [](const dvec3&) { return Tissue::kEnamel; });
  options_.ideal.reset();
  options_.preparation.reset();
  // Looks from each side, tilted as this view is. An upright rod must be upright in the picture.
  const std::string seen = told_by(
      "{const v = document.getElementById('viewer'), c = v.querySelector('canvas'); c.setPointerCapture = () => {};"
      "const at = (kind, x) => c.dispatchEvent(new PointerEvent(kind, {clientX: x, clientY: 200, pointerId: 1}));"
      "const before = c.toDataURL(); at('pointerdown', 300); at('pointermove', 395); at('pointerup', 395);"
      "setTimeout(() => {"
      "const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let l = 1e9, r = 0, t = 1e9, b = 0;"
      "for (let i = 0; i < d.length / 4; ++i) if (d[4 * i + 3]) { const x = i % c.width, y = Math.floor(i / c.width);"
      "l = Math.min(l, x); r = Math.max(r, x); t = Math.min(t, y); b = Math.max(b, y); }"
      "document.body.dataset.seen = [r - l + 1, b - t + 1, before === c.toDataURL() ? 0 : 1].join(' '); }, 500);}");
  double width = 0, height = 0, turned = 0;
  std::istringstream(seen) >> width >> height >> turned;
  EXPECT_GT(height, 50) << seen;
  EXPECT_LT(width, 0.2 * height) << seen;
  EXPECT_EQ(turned, 1) << seen;
}

TEST_F(ReportInABrowser, TwoFingersZoom) {
  options_.result = box(glm::vec3(2e-3f), [](const dvec3&) { return Tissue::kEnamel; });
  options_.ideal.reset();
  options_.preparation.reset();
  // Moves the fingers to half their distance. Counts the drawn pixels of the middle row.
  const std::string seen = told_by(
      "{const v = document.getElementById('viewer'), c = v.querySelector('canvas'); c.setPointerCapture = () => {};"
      "const at = (kind, id, x) => c.dispatchEvent(new PointerEvent(kind, {clientX: x, clientY: 200, pointerId: id}));"
      "const width = () => { const d = c.getContext('2d').getImageData(0, c.height / 2, c.width, 1).data; let n = 0;"
      "for (let i = 3; i < d.length; i += 4) n += d[i] ? 1 : 0; return n; };"
      "const before = width(); at('pointerdown', 1, 200); at('pointerdown', 2, 300); at('pointermove', 2, 250);"
      "at('pointerup', 1, 200); at('pointerup', 2, 250);"
      "setTimeout(() => { document.body.dataset.seen = [before, width()].join(' '); }, 500);}");
  double before = 0, after = 0;
  std::istringstream(seen) >> before >> after;
  EXPECT_GT(before, 50) << seen;
  EXPECT_NEAR(after / before, 0.5, 0.03) << seen;
}

TEST_F(ReportInABrowser, IsReadableInLightAndDarkModeAndOnPaper) {
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

TEST_F(ReportInABrowser, IsUsableWithScreenReaderKeyboardLargeTextPhoneAndPaper) {
  for (const Language language : {Language::kEnglish, Language::kGerman, Language::kChinese}) {
    const SessionReader session(browser_ / "s.h5");
    options_.language = language;
    options_.earlier = {summarize(session)};
    options_.expert = summarize(session);
    const std::string page = browser_.write("read.html", report_html(session, options_));
    const typodont::test::ProgramFolder python("/usr/bin/python3");
    const typodont::test::Ran ran = expect_ok(python.run(
        fmt::format("{} {} {} {}", TYPODONT_PAGE_CHECK, TYPODONT_BROWSER, page, tag_of(language).substr(0, 2)),
        "timeout 280"));
    EXPECT_THAT(ran.out, HasSubstr("looked at"));
  }
}

}  // namespace
}  // namespace typodont::session
