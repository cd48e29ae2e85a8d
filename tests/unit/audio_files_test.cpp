#include <fmt/format.h>
#include <gmock/gmock.h>

#include "audio/ar/resample.h"
#include "audio/compare.h"
#include "audio/contact_track.h"
#include "audio/sound_models.h"
#include "tests/support/audio_signals.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;
using ::testing::AllOf;
using ::testing::HasSubstr;

class Files : public ::testing::Test {
 protected:
  std::string model_refusal(const std::string& text) {
    write_text(folder_ / "m.json", text);
    return refusal([&] { load_model(folder_ / "m.json"); });
  }
  std::string track_refusal(const std::string& text) {
    write_text(folder_ / "c.csv", text);
    return refusal([&] { read_contact_track(folder_ / "c.csv"); });
  }
  static std::vector<SoundState> voiced(const ContactTrack& track, double free_speed) {
    std::vector<SoundState> states;
    VoicedTrack all(track, free_speed);
    while (const auto state = all.next()) states.push_back(*state);
    return states;
  }
  ContactTrack track(const std::string& text) {
    write_text(folder_ / "c.csv", text);
    return read_contact_track(folder_ / "c.csv");
  }
  Folder folder_;
};

TEST_F(Files, OfModelsAreReadBackWithTheSameBits) {
  std::mt19937 random(1);
  ArModel model = random_model(random, 300);
  model.source = "a \"quoted\" recording";
  model.licence = "MIT";
  model.samples = 12345;
  model.lines = {{3200.5, 0.03, {{-0.9, 0.1}, 0.02}, {{0.3}, 1.7}}, {6401, 0.01, {}, {}}};
  write_text(folder_ / "m.json", to_json(model));
  const ArModel back = load_model(folder_ / "m.json");
  ASSERT_EQ(back.lines.size(), 2u);
  EXPECT_EQ(back.lines[0].frequency, 3200.5);
  EXPECT_EQ(back.lines[0].amplitude, 0.03);
  EXPECT_EQ(back.lines[0].amplitude_noise.reflection, model.lines[0].amplitude_noise.reflection);
  EXPECT_EQ(back.lines[0].frequency_noise.gain, 1.7);
  EXPECT_EQ(back.lines[1].frequency_noise.deviation(), 0);
  EXPECT_EQ(back.reflection, model.reflection);
  EXPECT_EQ(back.gain, model.gain);
  EXPECT_EQ(back.rate, model.rate);
  EXPECT_EQ(back.source, model.source);
  EXPECT_EQ(back.samples, model.samples);
}

TEST_F(Files, OfModelsWithMistakesAreRefusedNamingTheKey) {
  EXPECT_THAT(model_refusal("{}"), HasSubstr("rate_Hz"));
  EXPECT_THAT(model_refusal(R"({"rate_Hz":48000,"gain":1,"reflection_coefficients":[0.5,1.0]})"),
              AllOf(HasSubstr("m.json"), HasSubstr("reflection_coefficients[1]"), HasSubstr("not stable")));
  EXPECT_THAT(model_refusal(R"({"rate_Hz":48000,"gain":-1,"reflection_coefficients":[0.5]})"), HasSubstr("gain"));
  EXPECT_THAT(model_refusal(R"({"rate_Hz":48000,"gain":1,"order":3,"reflection_coefficients":[0.5]})"),
              HasSubstr("order"));
  EXPECT_THAT(model_refusal(R"({"rate_Hz":48000,"gain":1,"pitch":3,"reflection_coefficients":[0.5]})"),
              HasSubstr("unknown key"));
  EXPECT_THAT(model_refusal("{"), HasSubstr("valid JSON"));
  EXPECT_THAT(model_refusal(R"({"rate_Hz":48000,"gain":1,"reflection_coefficients":[0.5],"lines":[{"frequency_Hz":3e4,
                "amplitude":0.1,"amplitude_noise":{"gain":0,"reflection_coefficients":[]},
                "frequency_noise_Hz":{"gain":0,"reflection_coefficients":[]}}]})"),
              HasSubstr("lines[0].frequency_Hz"));
  EXPECT_THAT(model_refusal(R"({"rate_Hz":48000,"gain":1,"reflection_coefficients":[0.5],"lines":7})"),
              HasSubstr("an array of lines"));
}

TEST_F(Files, OfVoicesNameTheirModelsAndTissues) {
  write_text(folder_ / "idle.json", to_json(model_of({0.1})));
  write_text(folder_ / "work.json", to_json(model_of({0.2})));
  write_text(folder_ / "v.json", R"({"kind":"voice","idle":"idle.json","working":{"dentin":"work.json"},
    "free_speed_krpm":40,"tones":[{"multiple":2,"level_dB":-20}],"level_dB":6})");
  const SoundModels models = load_sound_models(folder_ / "v.json");
  EXPECT_DOUBLE_EQ(models.working[static_cast<std::size_t>(Tissue::kDentin)]->reflection[0], 0.2);
  EXPECT_FALSE(models.working[static_cast<std::size_t>(Tissue::kEnamel)]);
  EXPECT_NEAR(models.free_speed, 40 * kKrpm, 1e-9);
  EXPECT_NEAR(models.tones.at(0).amplitude, 0.1, 1e-12);
  EXPECT_NEAR(models.level, 1.9953, 1e-4);

  write_text(folder_ / "v.json", R"({"kind":"voice","idle":"gone.json"})");
  EXPECT_THAT(refusal([&] { load_sound_models(folder_ / "v.json"); }),
              AllOf(HasSubstr("idle"), HasSubstr("gone.json")));
  write_text(folder_ / "v.json", R"({"kind":"voice","idle":"idle.json","working":{"cheese":"work.json"}})");
  EXPECT_THAT(refusal([&] { load_sound_models(folder_ / "v.json"); }), HasSubstr("cheese"));
}

// A voice's file states how loud the drill is at work. The voice must have this level, for any levels that its sound
// allows.
TEST_F(Files, OfVoicesSayHowLoudTheDrillIsAtWork) {
  write_text(folder_ / "idle.json", to_json(resonance(0.5, 0.9, 0.02)));
  const auto voice = [&](double level, double high) {
    write_text(folder_ / "v.json",
               fmt::format(R"({{"kind":"voice","idle":"idle.json","free_speed_krpm":40,"work":{{"tissue":"dentin",
      "force_N":2,"spindle_krpm":36,"level_dB":{},"level_above_4kHz_dB":{},"source":"test"}}}})",
                           level, high));
    return load_sound_models(folder_ / "v.json");
  };
  for (const auto& [level, high] : {std::pair{5.0, 6.0}, {8.0, 9.0}, {10.0, 10.5}}) {
    const SoundModels models = voice(level, high);
    DrillSynth synth(models, 48000, 1);
    SoundState idle, work;
    idle.spindle = models.free_speed;
    work = idle;
    work.t = from_seconds(4);
    work.spindle = 36 * kKrpm;
    work.force = 2;
    work.tissue = Tissue::kDentin;
    synth.push(idle);
    synth.push(work);
    std::vector<float> y(8 * 48000);
    synth.render(y);
    const auto half = static_cast<std::ptrdiff_t>(y.size() / 2);
    const std::vector<double> before(y.begin(), y.begin() + half), after(y.begin() + half + 4800, y.end());
    EXPECT_NEAR(10 * std::log10(power_of_samples(after) / power_of_samples(before)), level, 0.2);
  }
  EXPECT_THAT(refusal([&] { voice(3, 15); }), HasSubstr("work"));
}

TEST_F(Files, OfContactGiveStatesInSiUnits) {
  const auto t = track(
      "t_s,spindle_krpm,force_N,contact_area_mm2,removal_mm3_per_s,tissue,pedal\n"
      "0,300,0,0,0,air,1\n0.5,250,1.5,0.8,0.4,dentin,0.5\n");
  ASSERT_EQ(t.states.size(), 2u);
  const SoundState& s = t.states[1];
  EXPECT_EQ(s.t, 500'000'000);
  EXPECT_NEAR(s.spindle, 250 * kKrpm, 1e-9);
  EXPECT_DOUBLE_EQ(s.force, 1.5);
  EXPECT_DOUBLE_EQ(s.contact_area, 0.8e-6);
  EXPECT_DOUBLE_EQ(s.removal_rate, 0.4e-9);
  EXPECT_EQ(s.tissue, Tissue::kDentin);
  EXPECT_NEAR(t.fastest, 300 * kKrpm, 1e-9);
}

TEST_F(Files, OfTicksGiveForceRemovalAndSlip) {
  std::string text =
      "t_s,hand_x_mm,tool_x_mm,tool_y_mm,tool_z_mm,force_x_N,force_y_N,force_z_N,normal_x,normal_y,normal_z,"
      "contact_area_mm2,removed_mm3,tissue,spindle_krpm,faults\n";
  for (int i = 0; i < 20; ++i) {  // slides 1 mm in x in 50 ms, sinks along the normal, cuts 0.5 mm³/s
    text += fmt::format("{},0,{},0,{},3,0,4,0,0,1,0.5,{},1,290,0\n", i * 1e-3, 0.02 * i, -0.01 * i, 0.5e-3 * i);
  }
  const auto t = track(text);
  const SoundState& s = t.states[19];
  EXPECT_DOUBLE_EQ(s.force, 5);
  EXPECT_NEAR(s.slip_speed, 0.02, 1e-9);
  EXPECT_NEAR(s.removal_rate, 0.5e-9, 1e-15);
  EXPECT_EQ(s.tissue, Tissue::kEnamel);
}

TEST_F(Files, OfContactWithMistakesAreRefusedNamingLineAndColumn) {
  EXPECT_THAT(track_refusal("t_s,force\n0,1\n"), HasSubstr("column \"force\""));
  EXPECT_THAT(track_refusal("t_s,force_N\n0,1\n0,2\n"), AllOf(HasSubstr("line 3"), HasSubstr("t_s")));
  EXPECT_THAT(track_refusal("t_s,force_N\n0,nan\n"), AllOf(HasSubstr("line 2"), HasSubstr("force_N")));
  EXPECT_THAT(track_refusal("t_s,force_N\n0,-1\n"), HasSubstr("-1"));
  EXPECT_THAT(track_refusal("t_s,tissue\n0,cheese\n"), AllOf(HasSubstr("cheese"), HasSubstr("tissue")));
  EXPECT_THAT(track_refusal("t_s,force_N\n"), HasSubstr("no rows"));
  EXPECT_THAT(track_refusal(""), HasSubstr("empty"));
  EXPECT_THAT(track_refusal("force_N\n1\n"), HasSubstr("t_s"));
}

TEST_F(Files, OfContactWithoutSpindleSpeedLoseSpeedToTheForce) {
  const auto t = track("t_s,force_N,contact_area_mm2\n0,0,0\n1,2,1\n");
  const auto states = voiced(t, 300 * kKrpm);
  EXPECT_NEAR(states.front().spindle, 300 * kKrpm, 1e-9);
  EXPECT_LT(states.back().spindle, 250 * kKrpm);
  EXPECT_GT(states.back().spindle, 200 * kKrpm);
}

TEST_F(Files, OfContactAreInterpolatedEveryMillisecond) {
  const auto states = voiced(track("t_s,spindle_krpm\n0,300\n1,200\n1.0005,100\n"), 1);
  ASSERT_EQ(states.size(), 1002u);
  EXPECT_EQ(states[500].t, 500'000'000);
  EXPECT_NEAR(states[500].spindle, 250 * kKrpm, 1e-6);
  EXPECT_EQ(states[1000].t, kNanosPerSecond);
  EXPECT_EQ(states[1000].spindle, 200 * kKrpm);
  EXPECT_EQ(states[1001].spindle, 100 * kKrpm);
}

TEST_F(Files, SoundSurvives16BitFilesWithinOneStep) {
  const auto x = sound_of(resonance(0.9, 0.5), 5000, 1);
  write_wav(folder_ / "a.wav", x, 44100, SampleFormat::kPcm16);
  const Recording back = read_recording(folder_ / "a.wav");
  EXPECT_EQ(back.rate, 44100);
  ASSERT_EQ(back.length(), x.size());
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(back.channels[0][i], x[i], 1.01 / 32768);
}

TEST_F(Files, ThatAreNoSoundAreRefused) {
  write_text(folder_ / "a.wav", "RIFF and then nothing");
  EXPECT_THAT(refusal([&] { read_recording(folder_ / "a.wav"); }), HasSubstr("a.wav"));
  EXPECT_THAT(refusal([&] { read_recording(folder_ / "gone.wav"); }), HasSubstr("No such file"));
  EXPECT_THAT(refusal([&] { read_recording(folder_ / ""); }), HasSubstr("directory"));
  write_wav(folder_ / "none.wav", std::vector<double>(), 48000);
  EXPECT_THAT(refusal([&] { read_recording(folder_ / "none.wav"); }), HasSubstr("no samples"));
  write_wav(folder_ / "long.wav", std::vector<double>(1'801'000, 0.1), 1000);
  EXPECT_THAT(refusal([&] { read_recording(folder_ / "long.wav"); }), HasSubstr("1801 s"));
}

TEST_F(Files, ComparedWithThemselvesAreZeroApartAndTwiceAsLoudIsSixDecibels) {
  const auto x = sound_of(resonance(0.9, 0.5), 48000, 1);
  std::vector<double> twice;
  for (const double v : x) twice.push_back(2 * v);
  write_wav(folder_ / "a.wav", x, 48000);
  write_wav(folder_ / "b.wav", twice, 48000);
  EXPECT_EQ(compare_sounds(folder_ / "a.wav", folder_ / "a.wav").distance_dB, 0);
  const auto c = compare_sounds(folder_ / "a.wav", folder_ / "b.wav");
  EXPECT_NEAR(c.level_difference_dB, 6.02, 0.01);
  EXPECT_NEAR(c.distance_dB, 6.02, 0.01);
  EXPECT_NEAR(c.shape_distance_dB, 0, 0.01);
}

TEST(Comparison, RecordingsOfDifferentSampleRatesAreComparedInHertz) {
  const Folder folder;
  const auto x = sound_of(resonance(0.9, 0.5), 3 * 48000, 1);
  write_wav(folder / "a.wav", x, 48000);
  write_wav(folder / "b.wav", resampled(x, 48000, 44100), 44100);
  EXPECT_LT(compare_sounds(folder / "a.wav", folder / "b.wav").distance_dB, 0.3);
}

TEST(ShippedVoices, LoadAndSound) {
  for (const auto& entry : std::filesystem::directory_iterator("assets/sounds")) {
    if (entry.path().extension() != ".json") continue;
    const SoundModels models = load_sound_models(entry.path());
    EXPECT_FALSE(models.source.empty()) << entry.path();
    EXPECT_FALSE(models.licence.empty()) << entry.path();
    DrillSynth synth(models, 48000, 1);
    SoundState state;
    state.spindle = models.free_speed > 0 ? models.free_speed : 1.0;
    synth.push(state);
    std::vector<float> y(48000);
    synth.render(y);
    const double level = 10 * std::log10(power_of_samples(y));
    EXPECT_GT(level, -40) << entry.path();
    EXPECT_LT(level, -10) << entry.path();
  }
}

}  // namespace
}  // namespace typodont::audio
