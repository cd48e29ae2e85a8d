// Tests the whole demo and its results: each result file is opened and examined.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "engine/render/picture.h"
#include "engine/session/film.h"
#include "engine/session/session_file.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using testing::HasSubstr;

double brightness(const render::Picture& picture) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4)
    sum += picture.rgba[i] + picture.rgba[i + 1] + picture.rgba[i + 2];
  return sum / static_cast<double>(picture.rgba.size() / 4 * 3);
}

/// Number of pixels with the lesion's brown in the middle of the picture, where the lesion is. The dentin of the cavity
/// is brighter, or yellower: its red is less than 1.3 times its green.
int brown(const render::Picture& picture) {
  int count = 0;
  for (int y = picture.size.y / 4; y < picture.size.y * 7 / 10; ++y) {
    for (int x = picture.size.x * 3 / 8; x < picture.size.x * 5 / 8; ++x) {
      const std::uint8_t* p = picture.at(x, y);
      count += p[0] > 20 && p[0] < 140 && p[0] > 1.3 * p[1] && p[1] > 1.05 * p[2];
    }
  }
  return count;
}

TEST(Demo, MakesPicturesAFilmOfTenSecondsSoundSessionAndReportOfACavityWhereTheLesionWas) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  const std::string out = folder / "demo";
  const Ran ran = expect_ok(folder.run("demo --fps 1 --size 480x270 --out " + out));
  EXPECT_THAT(ran.out, HasSubstr("Made in"));
  for (int s = 10; s <= 80; s += 10) EXPECT_TRUE(std::filesystem::exists(fmt::format("{}/at_{:03}_s.png", out, s)));

  // Both eyes see the tooth from different positions. At the end of the session, the lesion is gone.
  const render::Picture before = render::read_png(out + "/before_left.png"),
                        right = render::read_png(out + "/before_right.png");
  const render::Picture after = render::read_png(out + "/after_left.png");
  EXPECT_GT(brightness(before), 40);
  EXPECT_GT(brightness(right), 40);
  EXPECT_NE(before.rgba, right.rgba);
  EXPECT_GT(brown(before), 560);
  EXPECT_LT(brown(after), 0.05 * brown(before));

  // The session is complete. All caries is removed except for rounding errors.
  const session::SessionReader session(out + "/session.h5");
  EXPECT_FALSE(session.truncated());
  EXPECT_GT(session.tick_count(), 20'000u);
  EXPECT_EQ(session.patches().empty(), false);
  const PerTissue removed = session.ticks(session.tick_count() - 1, 1).at(0).removed;
  const auto of = [](const PerTissue& volumes, Tissue tissue) { return volumes[static_cast<std::size_t>(tissue)]; };
  EXPECT_GT(of(removed, Tissue::kCaries), 0.98 * of(session.header().volumes_before, Tissue::kCaries));
  EXPECT_EQ(of(removed, Tissue::kPulp), 0);
  // The expert without a camera (bench_expert) removes 7.5 mm³ of sound tissue; the hand that this film shows does the
  // same work.
  EXPECT_LT(of(removed, Tissue::kEnamel) + of(removed, Tissue::kDentin), 9e-9);

  expect_ok(folder.run("replay " + out + "/session.h5 --check --json"));

  // The sound is as long as the session. The report contains plots and pictures and loads nothing from the network.
  const double seconds = to_seconds(session.ticks(session.tick_count() - 1, 1).at(0).t);
  const auto wav_bytes = static_cast<double>(std::filesystem::file_size(out + "/drill.wav"));
  EXPECT_NEAR(wav_bytes / 2 / 48000, seconds, 0.2);
  const std::string html = read_text(out + "/report.html");
  EXPECT_THAT(html, HasSubstr("<svg"));
  EXPECT_THAT(html, HasSubstr("data:image/png;base64,"));
  EXPECT_EQ(html.find("src=\"http"), std::string::npos);
  if (session::find_ffmpeg()) {
    EXPECT_GT(std::filesystem::file_size(out + "/session.mp4"), 20'000u);
    EXPECT_THAT(ran.out, HasSubstr("film with sound, 10 frames"));
  }
}

TEST(Demo, AnUnwritableFolderIsRefused) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  expect_exit(folder.run("demo --out /proc/nowhere"), 2, "/proc/nowhere");
}

}  // namespace
}  // namespace typodont
