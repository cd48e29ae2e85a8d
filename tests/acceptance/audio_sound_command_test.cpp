// Tests `typodont sound` as users run it: the program, its files, and its exit statuses.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>

#include "audio/ar/lines.h"
#include "audio/ar/rotor.h"
#include "audio/compare.h"
#include "audio/sound_file.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/render/picture.h"
#include "tests/support/audio_signals.h"
#include "tests/support/program.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;

class SoundCommand : public ::testing::Test {
 protected:
  Ran run(const std::string& arguments) const { return folder_.run("sound " + arguments); }
  std::string path(const std::string& name) const { return folder_ / name; }
  /// Returns the number of files, without the program's output.
  std::ptrdiff_t files_left() const {
    const std::filesystem::directory_iterator files(folder_.path());
    return std::count_if(begin(files), end(files),
                         [](const auto& e) { return e.path().filename().string()[0] != '.'; });
  }

  ProgramFolder folder_{TYPODONT_PROGRAM};
};

const std::string kMicromotor = "assets/sounds/micromotor_steady.wav";

/// Reads the axis of a picture as a person does, from the marks left of the plot, from 0 Hz upwards.
struct ReadAxis {
  render::Picture picture;
  int left = 0;            // the plot's first column
  std::vector<int> marks;  // rows, from below

  explicit ReadAxis(const std::filesystem::path& file) : picture(render::read_png(file)) {
    // There is no long dark line left of the plot: marks are a few pixels wide, and letters are not straight lines.
    const auto dark = [&](int x, int y) { return picture.at(x, y)[0] < 100 && picture.at(x, y)[1] < 100; };
    while (left < picture.size.x && !dark(left, picture.size.y / 2 + 15)) ++left;
    if (left < 5 || left == picture.size.x) return;  // no axis
    for (int y = picture.size.y - 1; y >= 0; --y) {
      bool mark = true;
      for (int x = left - 5; x < left; ++x) mark &= dark(x, y);
      if (mark) marks.push_back(y);
    }
  }
  double frequency(double row, double step_Hz) const {
    const double pixels = static_cast<double>(marks.front() - marks.back()) / static_cast<double>(marks.size() - 1);
    return (marks.front() - row) / pixels * step_Hz;
  }
  /// Returns the median of the brightest row over these columns (fractions of the plot). The median is used because a
  /// tone may rise and fall.
  double brightest_row(double from, double to) const {
    const int wide = picture.size.x - left;
    std::vector<double> rows;
    for (int x = left + static_cast<int>(from * wide); x < left + static_cast<int>(to * wide); ++x) {
      int best = -1;
      double row = 0;
      for (int y = marks.back(); y < marks.front(); ++y) {
        const int light = picture.at(x, y)[0] + picture.at(x, y)[1] + picture.at(x, y)[2];
        if (light > best) best = light, row = y + 0.5;
      }
      rows.push_back(row);
    }
    std::nth_element(rows.begin(), rows.begin() + std::ssize(rows) / 2, rows.end());
    return rows[rows.size() / 2];
  }
};

TEST_F(SoundCommand, APictureShowsAToneAtItsFrequencyOnItsAxis) {
  for (const double tone : {1000.0, 5833.3, 9500.0}) {
    const double rate = 48000;
    std::vector<float> sound;
    for (int i = 0; i < 2 * 48000; ++i) sound.push_back(static_cast<float>(0.3 * std::sin(2 * kPi * tone * i / rate)));
    WavWriter wav(path("tone.wav"), rate);
    wav.write(sound);
    wav.finish();
    const auto drawn = expect_ok(run("picture " + path("tone.wav") + " --out " + path("tone.png") + " --json"));
    const ReadAxis axis(path("tone.png"));
    EXPECT_EQ(axis.left, static_cast<int>(Json::parse(drawn.out, "out")["plot_px"].items().at(0).number()));
    ASSERT_EQ(axis.marks.size(), 7u) << "0 to 12 kHz in steps of 2";
    EXPECT_NEAR(axis.frequency(axis.brightest_row(0.1, 0.9), 2000), tone, 50);
  }
  EXPECT_EQ(run("picture " + path("tone.wav") + " --up-to-hz 30000 --out " + path("x.png")).status, 2);
  EXPECT_FALSE(std::filesystem::exists(path("x.png")));
}

TEST_F(SoundCommand, TheReadmesPictureShowsTheTurbineAtItsSpeed) {
  const ReadAxis axis("docs/pictures/drill_spectrogram.png");
  ASSERT_EQ(axis.marks.size(), 7u);
  const double free_Hz = Json::load("assets/motors/air_turbine.json")["free_speed_krpm"].number() * 1000 / 60;
  // In the last quarter, where the bur hardly cuts, it rotates at the free speed.
  EXPECT_NEAR(axis.frequency(axis.brightest_row(0.82, 0.97), 2000), free_Hz, 0.03 * free_Hz);
}

TEST_F(SoundCommand, FitsARecordingAndTheModelHasItsSpectrum) {
  const auto fit = expect_ok(run("fit " + kMicromotor + " --out " + path("m.json") + " --json"));
  const Json report = Json::parse(fit.out, "report");
  EXPECT_EQ(report["order"].integer(), 300);
  EXPECT_LT(report["log_spectral_distance_dB"].number(), 0.5);
  ASSERT_EQ(run("synth " + path("m.json") + " --seconds 20 --out " + path("m.wav")).status, 0);
  const auto same =
      expect_ok(run("compare " + kMicromotor + " " + path("m.wav") + " --constant-speed --at-most-db 0.6 --json"));
  const Json compared = Json::parse(same.out, "comparison");
  EXPECT_LT(std::abs(compared["level_difference_dB"].number()), 0.5);
  // The rotor's whistle is as steady as in the recording; filtered noise of this spectrum varies by 0.5.
  const double recorded = compared["a"]["tone_variation"].items()[0].number();
  EXPECT_LT(recorded, 0.2);
  EXPECT_NEAR(compared["b"]["tone_variation"].items()[0].number(), recorded, 0.2 * recorded);
}

TEST_F(SoundCommand, TwoDifferentDrillsExceedTheLimitOfTheComparison) {
  expect_exit(run("compare " + kMicromotor + " assets/sounds/drill_spinup_run_spindown.wav --at-most-db 1"), 1,
              "more than 1 dB");
}

TEST_F(SoundCommand, EqualSeedsGiveEqualBytesAndDifferentSeedsDifferentBytes) {
  const std::string synth = "synth assets/sounds/air_turbine.json --seconds 1 --out ";
  ASSERT_EQ(run(synth + path("a.wav")).status, 0);
  ASSERT_EQ(run(synth + path("b.wav")).status, 0);
  ASSERT_EQ(run(synth + path("c.wav") + " --seed 2").status, 0);
  EXPECT_EQ(read_text(folder_ / "a.wav"), read_text(folder_ / "b.wav"));
  EXPECT_NE(read_text(folder_ / "a.wav"), read_text(folder_ / "c.wav"));
}

TEST_F(SoundCommand, BadInputExitsWithTwoAndAReasonAndLeavesNoFile) {
  write_wav(folder_ / "silence.wav", std::vector<double>(48000, 0.0), 48000);
  write_text(folder_ / "cut.wav", read_text(kMicromotor).substr(0, 30));
  write_text(folder_ / "bad.csv", "t_s,force_N\n0,nan\n");
  write_text(folder_ / "long.csv", "t_s,force_N\n0,1\n1000000,1\n");
  write_text(folder_ / "bad.json", R"({"rate_Hz":48000,"gain":1,"reflection_coefficients":[2]})");
  const std::string model = "assets/sounds/micromotor_ar300.json";
  const std::map<std::string, std::string> cases = {
      {"fit " + path("silence.wav") + " --out " + path("o.json"), "silence"},
      {"fit " + path("cut.wav") + " --out " + path("o.json"), "cut.wav"},
      {"fit " + path("gone.wav") + " --out " + path("o.json"), "No such file"},
      {"fit " + kMicromotor + " --order 0 --out " + path("o.json"), "--order"},
      {"fit " + kMicromotor + " --order 5000 --out " + path("o.json") + " --to 0.5", "too short for order 5000"},
      {"fit " + kMicromotor + " --out /no/such/place/o.json", "writable"},
      {"fit " + kMicromotor, "--out"},
      {"synth " + model + " --out " + path("o.wav"), "--seconds"},
      {"synth " + model + " --seconds -1 --out " + path("o.wav"), "--seconds"},
      {"synth " + model + " --seconds nan --out " + path("o.wav"), "--seconds"},
      {"synth " + model + " --seconds 1 --out /no/such/place/o.wav", "writable"},
      {"synth " + path("bad.json") + " --seconds 1 --out " + path("o.wav"), "reflection_coefficients[0]"},
      {"synth " + model + " --contact " + path("bad.csv") + " --out " + path("o.wav"), "line 2"},
      {"synth " + model + " --contact " + path("long.csv") + " --out " + path("o.wav"), "at most 36000 s"},
      {"synth " + model + " --seconds 1 --rate 10 --out " + path("o.wav"), "--rate"},
      {"compare " + kMicromotor + " " + path("gone.wav"), "gone.wav"},
      {"sing", "subcommand"},
  };
  const auto before = files_left();
  for (const auto& [arguments, reason] : cases) {
    expect_exit(run(arguments), 2, reason);
    EXPECT_EQ(files_left(), before) << arguments;
  }
}

TEST_F(SoundCommand, WritesAPageWithBothSoundsEachLineAndTheMeasuresAndFetchesNothing) {
  const std::string name = path("<b>&.wav");  // a name that would be HTML markup
  std::filesystem::copy_file(kMicromotor, name);
  expect_ok(run("page '" + name + "' --out " + path("p.html")));
  const std::string page = read_text(path("p.html"));
  const auto count = [&](const std::string& what) {
    int found = 0;
    for (std::size_t at = 0; (at = page.find(what, at)) != std::string::npos; at += what.size()) ++found;
    return found;
  };
  EXPECT_EQ(count("data:audio/wav;base64,"), 2);
  EXPECT_EQ(count("data:image/png;base64,"), 2);
  EXPECT_EQ(count("http:") + count("https:"), 0);  // base64 has no colon
  EXPECT_EQ(count("<b>"), 0);
  EXPECT_EQ(count("&lt;b&gt;&amp;.wav"), 2);  // title and heading
  std::smatch found;
  ASSERT_TRUE(std::regex_search(page, found, std::regex("constant speed</th><td>([0-9.]+) dB")));
  EXPECT_LE(std::stod(found[1]), 0.5);
  const std::regex row("<tr><td>[0-9]+</td><td>[0-9]+ %</td><td>[0-9]+ %</td><td>([+-][0-9]+) %</td></tr>");
  int lines = 0;
  for (std::sregex_iterator i(page.begin(), page.end(), row), end; i != end; ++i, ++lines)
    EXPECT_LE(std::abs(std::stoi((*i)[1])), 20) << i->str();
  EXPECT_GE(lines, 8);
}

TEST_F(SoundCommand, SynthesizesSoundFromServoTicks) {
  std::string ticks =
      "t_s,hand_x_mm,hand_y_mm,hand_z_mm,tool_x_mm,tool_y_mm,tool_z_mm,force_x_N,force_y_N,force_z_N,"
      "torque_x_Nmm,torque_y_Nmm,torque_z_Nmm,depth_mm,normal_x,normal_y,normal_z,contact_area_mm2,"
      "removed_mm3,removed_enamel_mm3,tissue,spindle_krpm,energy_mJ,tick_us,faults\n";
  for (int i = 0; i < 2000; ++i) {
    const bool cuts = i >= 1000;
    ticks += fmt::format("{},0,0,0,0,0,0,0,0,{},0,0,0,0,0,0,{},{},{},0,{},{},0,2.5,0\n", i * 1e-3, cuts ? 1.2 : 0,
                         cuts ? 1 : 0, cuts ? 0.6 : 0, cuts ? 0.4e-3 * (i - 1000) : 0, cuts ? "enamel" : "air",
                         cuts ? 270 : 300);
  }
  write_text(folder_ / "ticks.csv", ticks);
  expect_ok(run("synth assets/sounds/air_turbine.json --contact " + path("ticks.csv") + " --out " + path("t.wav")));
  const auto x = read_recording(folder_ / "t.wav").mono();
  const std::span<const double> free(x.data(), 47000), working(x.data() + 49000, x.size() - 49000);
  EXPECT_NEAR(spectral_lines(free, 48000, 6).front().frequency, 5000, 20);
  EXPECT_GT(power_of_samples(working), 1.5 * power_of_samples(free));
}

}  // namespace
}  // namespace typodont::audio
