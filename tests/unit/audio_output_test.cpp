#include "audio/audio_output.h"

#include <gmock/gmock.h>

#include <numeric>

#include "audio/drill_synth.h"
#include "audio/output/device_output.h"
#include "tests/support/audio_signals.h"
#include "tests/support/no_alloc.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;
using ::testing::HasSubstr;

/// A source that marks the sample nearest to each of a list of times.
struct Marker {
  std::vector<Nanos> ticks;
  double rate = 48000;
  std::size_t next = 0;
  int calls = 0;
  double told_rate = 0;

  static void render(void* self, std::span<float> mono, Nanos t_first) noexcept {
    auto& m = *static_cast<Marker*>(self);
    ++m.calls;
    std::fill(mono.begin(), mono.end(), 0.0f);
    while (m.next < m.ticks.size()) {
      const auto at = std::llround(static_cast<double>(m.ticks[m.next] - t_first) * 1e-9 * m.rate);
      if (at >= static_cast<long long>(mono.size())) break;
      mono[static_cast<std::size_t>(std::max(0ll, at))] = 1.0f;
      ++m.next;
    }
  }
  static void rate_changed(void* self, double rate) { static_cast<Marker*>(self)->told_rate = rate; }
  AudioSource source() { return {this, &render, &rate_changed}; }
};

/// An emulated sound card. The test controls its clock and its failures.
struct Card {
  StreamRequest request;
  double rate = 48000;
  bool present = true, open = false, started = false;
  int opened = 0;
  std::vector<float> played;

  void play(Nanos t, int channels = 1, bool underrun = false, int frames = 256) {
    std::vector<float> out(static_cast<std::size_t>(frames * channels));
    request.callback(request.self, out.data(), frames, channels, t, underrun);
    played.insert(played.end(), out.begin(), out.end());
  }
};

class FakeBackend final : public StreamBackend {
 public:
  explicit FakeBackend(Card& card) : card_(card) {}
  StreamOpened open(const StreamRequest& request) override {
    ++card_.opened;
    if (!card_.present) throw RunFailure("gone");
    card_.request = request;
    card_.open = true;
    return {"card", card_.rate, 0.01};
  }
  void start() override { card_.started = true; }
  bool alive() noexcept override { return card_.present && card_.open; }
  void close() noexcept override { card_.open = card_.started = false; }

 private:
  Card& card_;
};

struct OutputOnADevice : testing::Test {
  Card card;
  DeviceOutput output{std::make_unique<FakeBackend>(card), "", {}};
  Marker marker;
};

TEST(Output, OfAnUnknownAddressIsRefusedNamingTheChoices) {
  for (const char* address : {"wav:", "speaker", "none:x", ""}) {
    EXPECT_THAT(test::refusal([&] { AudioOutput::open(address); }), HasSubstr("none:"));
  }
}

TEST(Output, WithoutOutputNoSoundIsSynthesized) {
  Marker marker;
  const auto output = AudioOutput::open("none:");
  output->start(marker.source(), 0);
  output->advance(kNanosPerSecond);
  output->stop();
  EXPECT_EQ(marker.calls, 0);
}

TEST(Output, ToAFileContainsEverySampleAndTicksAtTheirTimes) {
  const Folder folder;
  Marker marker;
  for (int i = 0; i < 90; ++i) marker.ticks.push_back(5 * kNanosPerSecond + i * 10'000'000ll + 123'456);
  const auto output = AudioOutput::open("wav:" + (folder / "out.wav").string());
  output->start(marker.source(), 5 * kNanosPerSecond);
  for (int i = 1; i <= 10; ++i) output->advance(5 * kNanosPerSecond + i * 100'000'000ll);
  EXPECT_EQ(output->stats().samples, 48000u);
  EXPECT_FALSE(std::filesystem::exists(folder / "out.wav"));
  output->stop();
  const auto x = read_recording(folder / "out.wav").mono();
  ASSERT_EQ(x.size(), 48000u);
  for (int i = 0; i < 90; ++i) {
    EXPECT_GT(x[static_cast<std::size_t>(std::llround((i * 0.01 + 123.456e-6) * 48000))], 0.9) << i;
  }
}

TEST_F(OutputOnADevice, ATickSoundsWithinOneBufferAndTwoMilliseconds) {
  // The card's clock is wrong by 40 ppm. The scheduler delays its callbacks by 0.1 ms on average, and sometimes by 2
  // ms.
  const Nanos start = now();
  std::mt19937 random(3);
  std::exponential_distribution<double> late(1 / 100e3);
  std::uniform_real_distribution<double> u(0, 1);
  for (int i = 0; i < 19000; ++i) marker.ticks.push_back(i * 1'000'000ll + static_cast<Nanos>(u(random) * 900'000));
  output.start(marker.source(), 0);
  const Nanos begun = now();
  const double true_rate = 48000 * (1 + 40e-6), buffer = 256 / true_rate * 1e9;
  for (int i = 0; i * 256 < 20 * 48000; ++i) {
    const double jitter = u(random) < 0.01 ? 2e6 * u(random) : late(random);
    card.play(begun + static_cast<Nanos>(i * buffer + jitter));
  }
  // Sample n leaves the program at begun + n / true_rate.
  std::vector<double> delays;
  std::size_t tick = 0;
  for (std::size_t n = 0; n < card.played.size(); ++n) {
    if (card.played[n] == 0) continue;
    while (tick + 1 < marker.ticks.size() && marker.ticks[tick + 1] <= marker.ticks[tick]) ++tick;
    const double leaves = static_cast<double>(n) / true_rate;
    if (leaves > 3) delays.push_back(leaves + to_seconds(begun - start) - to_seconds(marker.ticks[tick]));
    ++tick;
  }
  ASSERT_GT(delays.size(), 10000u);
  const double mean = std::accumulate(delays.begin(), delays.end(), 0.0) / static_cast<double>(delays.size());
  // The session's time zero is between `start` and `begun`. On a busy machine this may take long, but it is not a delay
  // of the output.
  EXPECT_LT(mean - to_seconds(begun - start), 256 / 48000.0 + 2e-3);
  EXPECT_GT(mean, 256 / 48000.0);
  for (const double d : delays) EXPECT_NEAR(d, mean, 1e-4);
}

TEST_F(OutputOnADevice, ToAStereoDeviceGivesBothEarsTheOneVoice) {
  marker.ticks = {0};
  output.start(marker.source(), 0);
  card.play(now(), 2);
  for (std::size_t i = 0; i < card.played.size(); i += 2) EXPECT_EQ(card.played[i], card.played[i + 1]);
}

/// A source of two channels: 0.25 on the left and -0.5 on the right.
AudioSource two_ears() {
  return {nullptr,
          [](void*, std::span<float> samples, Nanos) noexcept {
            for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = i % 2 == 0 ? 0.25f : -0.5f;
          },
          nullptr};
}

TEST(Output, OfTwoChannelsGoesToBothChannelsOfAFile) {
  const Folder folder;
  const auto output = AudioOutput::open("wav:" + (folder / "out.wav").string(), {.channels = 2});
  output->start(two_ears(), 0);
  output->advance(100'000'000);
  EXPECT_EQ(output->stats().samples, 4800u);
  output->stop();
  const Recording heard = read_recording(folder / "out.wav");
  ASSERT_EQ(heard.channels.size(), 2u);
  ASSERT_EQ(heard.length(), 4800u);
  for (const std::size_t i : {0u, 1u, 4799u}) {
    EXPECT_NEAR(heard.channels[0][i], 0.25, 1e-4);
    EXPECT_NEAR(heard.channels[1][i], -0.5, 1e-4);
  }
}

TEST(Output, OfTwoChannelsGoesToTheFirstTwoOfADeviceOrAsTheirMeanToItsOnlyOne) {
  Card card;
  DeviceOutput output(std::make_unique<FakeBackend>(card), "", {.channels = 2});
  output.start(two_ears(), 0);
  EXPECT_EQ(card.request.channels, 2);
  card.play(now(), 4);
  for (std::size_t i = 0; i < card.played.size(); ++i) {
    const float expected[4] = {0.25f, -0.5f, 0, 0};
    ASSERT_EQ(card.played[i], expected[i % 4]) << i;
  }
  card.played.clear();
  card.play(now(), 1);
  for (const float v : card.played) ASSERT_EQ(v, -0.125f);
}

TEST_F(OutputOnADevice, ALostDeviceIsReportedAndReopenedAtItsNewRate) {
  output.start(marker.source(), 0);
  card.play(now());
  output.advance(100'000'000);
  EXPECT_EQ(output.stats().losses, 0u);

  card.present = false;
  testing::internal::CaptureStderr();
  for (Nanos t = 200'000'000; t < 3 * kNanosPerSecond; t += 100'000'000) output.advance(t);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("card is lost"));
  EXPECT_EQ(output.stats().losses, 1u);
  EXPECT_EQ(card.opened, 1 + 3);  // once a second, not more

  card.present = true;
  card.rate = 44100;
  testing::internal::CaptureStderr();
  for (Nanos t = 3 * kNanosPerSecond; t < 5 * kNanosPerSecond; t += 100'000'000) {
    output.advance(t);
    if (card.started) card.play(now());
  }
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("card is back"));
  EXPECT_EQ(output.stats().recoveries, 1u);
  EXPECT_EQ(marker.told_rate, 44100);
  EXPECT_EQ(output.sample_rate(), 44100);
}

TEST_F(OutputOnADevice, ToADeviceThatOnlyStopsCallingCountsAsLost) {
  output.start(marker.source(), 0);
  output.advance(300'000'000);
  EXPECT_EQ(output.stats().losses, 0u);
  output.advance(700'000'000);
  EXPECT_EQ(output.stats().losses, 1u);
}

TEST_F(OutputOnADevice, UnderrunsAreCountedAndReported) {
  output.start(marker.source(), 0);
  card.play(now(), 1, true);
  testing::internal::CaptureStderr();
  output.advance(1);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("1 under-runs"));
  EXPECT_EQ(output.stats().underruns, 1u);
}

TEST_F(OutputOnADevice, DoesNotAllocateInTheCallback) {
  output.start(marker.source(), 0);
  std::vector<float> out(512);
  const NoAlloc guard;
  for (int i = 0; i < 100; ++i) card.request.callback(card.request.self, out.data(), 512, 1, i * 10'000'000ll, false);
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace typodont::audio
