// Tests PortAudio without a sound card. ALSA's plugin `file` over `null` gives the content; a dummy JACK server gives
// the timing.
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <thread>

#include "audio/audio_output.h"
#include "audio/drill_synth.h"
#include "engine/base/ring.h"
#include "tests/support/audio_signals.h"

namespace typodont::audio {
namespace {

using namespace typodont::test;
using ::testing::HasSubstr;

struct Drill {
  DrillSynth synth;
  static void render(void* self, std::span<float> mono, Nanos) noexcept {
    static_cast<Drill*>(self)->synth.render(mono);
  }
};

struct AlsaConfiguration {
  explicit AlsaConfiguration(const std::filesystem::path& file) { setenv("ALSA_CONFIG_PATH", file.c_str(), 1); }
  ~AlsaConfiguration() { unsetenv("ALSA_CONFIG_PATH"); }
};

TEST(PortAudioOnAlsa, PlaysTheSynthesizersSamples) {
  const Folder folder;
  write_text(folder / "asound.conf",
             "</usr/share/alsa/alsa.conf>\n"
             "pcm.tofile { type file slave.pcm { type null } file \"" +
                 (folder / "card.wav").string() +
                 "\" format \"wav\" }\n"
                 "pcm.testcard { type plug slave { pcm \"tofile\" format S16_LE rate 48000 channels 2 } }\n");
  const AlsaConfiguration configuration(folder / "asound.conf");

  const SoundModels models = load_sound_models("assets/sounds/micromotor.json");
  SoundState idle;
  idle.spindle = models.free_speed;
  Drill drill{DrillSynth(models, 48000, 1)};
  drill.synth.push(idle);
  AudioOptions options;
  options.sample_rate = 48000;
  options.end_after = 24000;  // nothing paces this device
  const auto output = AudioOutput::open("portaudio:testcard", options);
  EXPECT_EQ(output->sample_rate(), 48000);
  output->start({&drill, &Drill::render, nullptr}, 0);
  for (int i = 0; i < 500 && output->stats().samples < 24000; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  output->stop();
  ASSERT_GE(output->stats().samples, 24000u);

  DrillSynth reference(models, 48000, 1);
  reference.push(idle);
  std::vector<float> expected(12000);
  reference.render(expected);
  const auto card = read_recording(folder / "card.wav");
  ASSERT_EQ(card.channels.size(), 2u);
  // Skips the silence with which PortAudio fills the device's buffer before it starts.
  const auto& left = card.channels[0];
  const auto sounding = std::find_if(left.begin(), left.end(), [](double v) { return v != 0; });
  const auto silence = static_cast<std::size_t>(sounding - left.begin());
  ASSERT_LE(silence, 4096u);
  ASSERT_GE(card.length(), silence + expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_NEAR(left[silence + i], static_cast<double>(expected[i]), 1.5 / 32768) << i;
    ASSERT_EQ(left[silence + i], card.channels[1][silence + i]);
  }
}

TEST(PortAudioOnAlsa, AnUnknownDeviceIsRefusedWithTheListOfDevices) {
  const Folder folder;
  write_text(folder / "asound.conf", "</usr/share/alsa/alsa.conf>\npcm.quietcard { type null }\n");
  const AlsaConfiguration configuration(folder / "asound.conf");
  EXPECT_THAT(test::refusal([&] { AudioOutput::open("portaudio:no such card"); }), HasSubstr("quietcard"));
}

#ifdef TYPODONT_JACKD

/// A JACK server for this test, without hardware, in real time.
class JackServer {
 public:
  JackServer() {
    name_ = "typodont" + std::to_string(getpid());
    setenv("JACK_NO_AUDIO_RESERVATION", "1", 1);
    setenv("JACK_NO_START_SERVER", "1", 1);
    setenv("JACK_DEFAULT_SERVER", name_.c_str(), 1);
    start();
  }
  ~JackServer() { stop(); }
  void start() {
    process_ = fork();
    if (process_ == 0) {
      freopen("/dev/null", "w", stdout);
      freopen("/dev/null", "w", stderr);
      execl(TYPODONT_JACKD, "jackd", "-n", name_.c_str(), "-r", "-d", "dummy", "-r48000", "-p256",
            static_cast<char*>(nullptr));
      _exit(127);
    }
  }
  void freeze() { kill(process_, SIGSTOP); }
  void thaw() { kill(process_, SIGCONT); }
  void stop() {
    if (process_ <= 0) return;
    thaw();
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }

 private:
  std::string name_;
  pid_t process_ = -1;
};

std::unique_ptr<AudioOutput> open_soon() {
  for (int i = 0;; ++i) {
    try {
      return AudioOutput::open("portaudio:system", {.sample_rate = 48000, .buffer = 256});
    } catch (const std::exception&) {
      if (i == 50) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
}

/// Ticks pass through a ring buffer as in the program. The source stores the time at which each tick's sample left.
struct Listener {
  Ring<Nanos> ring{4096};
  std::vector<Nanos> waiting;
  std::vector<double> delays;  // s
  Nanos offset = 0;            // tick time − host time

  Listener() {
    waiting.reserve(4096);
    delays.reserve(100000);
  }
  static void render(void* self, std::span<float> mono, Nanos t_first) noexcept {
    auto& l = *static_cast<Listener*>(self);
    const Nanos called = now() + l.offset;
    Nanos t;
    while (l.ring.pop(t) && l.waiting.size() < l.waiting.capacity()) l.waiting.push_back(t);
    std::size_t kept = 0;
    for (const Nanos tick : l.waiting) {
      const double at = std::max(0.0, static_cast<double>(tick - t_first) * 48e-6);
      if (at < static_cast<double>(mono.size())) {
        if (l.delays.size() < l.delays.capacity()) l.delays.push_back(to_seconds(called - tick) + at / 48000);
      } else {
        l.waiting[kept++] = tick;
      }
    }
    l.waiting.resize(kept);
    std::fill(mono.begin(), mono.end(), 0.0f);
  }
};

TEST(PortAudioOnJack, SoundsAContactWithinOneBufferAndTwoMilliseconds) {
  const JackServer server;
  const auto output = open_soon();
  Listener listener;
  const Nanos start = now();
  listener.offset = -start;
  output->start({&listener, &Listener::render, nullptr}, 0);
  for (int i = 0; i < 3000; ++i) {  // three seconds of ticks at 1 kHz
    std::this_thread::sleep_until(
        std::chrono::steady_clock::time_point(std::chrono::nanoseconds(start + i * 1'000'000ll)));
    listener.ring.push(now() - start);
    if (i % 100 == 0) output->advance(now() - start);
  }
  output->stop();
  ASSERT_GT(listener.delays.size(), 1500u);
  std::sort(listener.delays.begin(), listener.delays.end());
  // Uses the median, because other work on the machine can cause delays of milliseconds.
  EXPECT_LT(listener.delays[listener.delays.size() / 2], 256 / 48000.0 + 2e-3);
  EXPECT_EQ(output->stats().losses, 0u);
}

TEST(PortAudioOnJack, AStallIsReportedAndSoundContinuesAfterwards) {
  JackServer server;
  const auto output = open_soon();
  Listener listener;
  const Nanos start = now();
  listener.offset = -start;
  output->start({&listener, &Listener::render, nullptr}, 0);
  const auto advance_until = [&](auto done) {
    for (int i = 0; i < 150 && !done(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      output->advance(now() - start);
    }
  };
  advance_until([&] { return output->stats().samples > 10000; });
  server.freeze();
  advance_until([&] { return output->stats().losses > 0; });
  EXPECT_EQ(output->stats().losses, 1u);
  server.thaw();
  advance_until([&] { return output->stats().recoveries > 0; });
  EXPECT_EQ(output->stats().recoveries, 1u);
  const auto before = output->stats().samples;
  advance_until([&] { return output->stats().samples > before + 10000; });
  EXPECT_GT(output->stats().samples, before + 10000);
  output->stop();
}

TEST(PortAudioOnJack, ADeadSoundServerStopsNeitherTheSessionNorTheEndOfTheProgram) {
  JackServer server;
  auto output = open_soon();
  Listener listener;
  const Nanos start = now();
  output->start({&listener, &Listener::render, nullptr}, 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  server.stop();
  Nanos longest = 0;
  for (int i = 0; i < 20; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const Nanos before = now();
    output->advance(before - start);
    longest = std::max(longest, now() - before);
  }
  EXPECT_EQ(output->stats().losses, 1u);
  EXPECT_LT(longest, kNanosPerSecond);
  output.reset();
}

#endif

}  // namespace
}  // namespace typodont::audio
