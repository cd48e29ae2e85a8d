#include "engine/app/guide/guide_stage.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <optional>
#include <thread>
#include <utility>

#include "audio/audio_output.h"
#include "engine/app/assets.h"
#include "engine/app/scene.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/realtime.h"
#include "engine/base/ring.h"
#include "engine/base/units.h"
#include "engine/display/keys.h"
#include "engine/display/output.h"
#include "engine/display/writing.h"
#include "engine/render/picture.h"
#include "haptics/devices.h"

namespace typodont {

using namespace calibration;
using namespace std::chrono_literals;

namespace {

/// Reads the hand on its own thread, without force. A touch is a point that the user touches with the tip and confirms
/// by pedal or key; take() returns one touch per call.
class GuideHand {
 public:
  struct Press {
    StillTouch::Verdict verdict = StillTouch::Verdict::kNone;
    dvec3 p_H{0};
    std::optional<ArmReading> reading;  // joint angles; empty if the device does not report them
    double moved = 0;                   // m, motion of the tip during the touch
  };

  explicit GuideHand(const GuideOptions& options) : still_(options.still), wait_for_prompt_(options.fast) {
    if (options.fast && !options.hand.starts_with("script:"))
      throw Error("--fast", "", options.hand, "a script: hand, others keep their own time");
    haptics::HandOptions hand;
    hand.paced = !options.fast;
    hand.pedal = options.pedal == "none" ? "" : options.pedal;
    hand.assets = assets_folder();
    // The arm's base and tool have no valid poses while they are calibrated, so the device's own frames are used.
    device_ = haptics::open_hand(options.hand, hand);
    thread_ = std::thread([this] { follow(); });
  }
  ~GuideHand() {
    stop_ = true;
    thread_.join();
  }
  GuideHand(const GuideHand&) = delete;
  GuideHand& operator=(const GuideHand&) = delete;

  const haptics::DeviceInfo& info() const { return device_->info(); }
  bool ended() const { return ended_.load(std::memory_order_acquire); }
  /// Confirms a touch by key, as the pedal does.
  void press() { asked_ = true; }
  /// From now on, touches are accepted; earlier ones are ignored.
  void ready() {
    asked_ = false;
    state_.store(State::kReady, std::memory_order_release);
  }
  std::optional<Press> take() {
    if (state_.load(std::memory_order_acquire) != State::kPressed) return std::nullopt;
    const Press press = press_;
    state_.store(State::kBusy, std::memory_order_release);
    return press;
  }

 private:
  enum class State { kBusy, kReady, kPressed };

  void follow() noexcept {
    // Real-time priority: late writes would trigger the device's safety layer.
    if (device_->info().force_limit > 0) enter_realtime({});
    haptics::HandSample sample;
    while (!stop_ && device_->read(sample)) {
      device_->write(dvec3(0), dvec3(0));
      const auto verdict = still_.add(sample.t, sample.X_WT.p, sample.pedal, asked_.exchange(false), device_->joints());
      if (verdict == StillTouch::Verdict::kNone) continue;
      while (wait_for_prompt_ && !stop_ && state_.load(std::memory_order_acquire) != State::kReady)
        std::this_thread::sleep_for(50us);
      if (state_.load(std::memory_order_acquire) != State::kReady) continue;
      press_ = {verdict, still_.point(), std::nullopt, still_.moved()};
      if (still_.has_joints()) press_.reading = ArmReading{still_.joints()};
      state_.store(State::kPressed, std::memory_order_release);
    }
    device_->release();
    ended_.store(true, std::memory_order_release);
  }

  StillTouch still_;  // detects touches; used only by the hand's thread
  bool wait_for_prompt_;
  std::unique_ptr<haptics::HapticDevice> device_;
  // Used by the hand's thread while `state_` is kReady, and by the main thread while it is kPressed.
  Press press_;
  std::atomic<State> state_{State::kBusy};
  std::atomic<bool> asked_{false}, stop_{false}, ended_{false};
  std::thread thread_;
};

/// Plays the sounds of the guide, one after the other.
class GuideVoice {
 public:
  explicit GuideVoice(const std::string& address)
      : file_(address.starts_with("wav:")), output_(audio::AudioOutput::open(address)) {
    make_sounds(output_->sample_rate());
    audio::AudioSource source;
    source.self = this;
    source.render = [](void* self, std::span<float> mono, Nanos) noexcept {
      static_cast<GuideVoice*>(self)->render(mono);
    };
    source.rate_changed = [](void* self, double rate) { static_cast<GuideVoice*>(self)->make_sounds(rate); };
    output_->start(source, 0);
    began_ = now();
  }
  void play(Cue cue) {
    cues_.push(cue);
    heard_at_ = std::max(heard_at_, now() - began_) + from_seconds(kLength);
    advance();
  }
  void advance() { output_->advance(now() - began_); }
  /// Waits until the latest sound has ended.
  void finish() {
    if (file_) output_->advance(std::max(heard_at_, now() - began_));
    const Nanos end = std::min(heard_at_ + from_seconds(0.1), now() - began_ + from_seconds(1));
    while (!file_ && now() - began_ < end) {
      advance();
      std::this_thread::sleep_for(20ms);
    }
    output_->stop();
  }

 private:
  static constexpr double kLength = 0.2;  // s, time for an event's sound; longer than every sound

  void make_sounds(double rate) {
    for (std::size_t i = 0; i < sounds_.size(); ++i) sounds_[i] = cue_sound(static_cast<Cue>(i), rate);
    playing_ = nullptr;
  }
  void render(std::span<float> mono) noexcept {
    for (float& out : mono) {
      if (playing_ && at_ >= playing_->size()) playing_ = nullptr;
      Cue cue;
      if (!playing_ && cues_.pop(cue)) playing_ = &sounds_[static_cast<std::size_t>(cue)], at_ = 0;
      out = playing_ ? (*playing_)[at_++] : 0.0f;
    }
  }

  bool file_;
  std::array<std::vector<float>, 5> sounds_;
  Ring<Cue> cues_{64};
  const std::vector<float>* playing_ = nullptr;  // used only by the audio thread
  std::size_t at_ = 0;
  Nanos began_ = 0, heard_at_ = 0;
  // Declared last: the output stops before its data is destroyed.
  std::unique_ptr<audio::AudioOutput> output_;
};

/// Properties of the screen, read from the rig file.
struct ScreenLook {
  display::Layout layout = display::Layout::kMono;
  glm::dmat2 upright{1.0};  // orientation of the text (Hud::upright)
};

ScreenLook look_of(const GuidedCapture& guide, const std::filesystem::path& file) {
  ScreenLook look;
  const bool in_mirror = guide.bench().rig.mirror.has_value() && guide.step() != Step::kScreen;
  if (in_mirror) look.upright = glm::dmat2(-1, 0, 0, 1);
  try {
    const display::DisplayRig rig = display::load_rig(file);
    look.layout = rig.screen.layout;
    if (in_mirror) look.upright = display::upright(rig);
  } catch (const Error& e) {  // before its calibration, the rig file describes no screen
    log::info("prompts are drawn plainly: {}", e.what());
  }
  return look;
}

/// The text as its reader sees it upright; the marks over it stay in place.
Picture prompt_picture(const Prompt& prompt, const glm::ivec2& size, const ScreenLook& look) {
  constexpr unsigned char kGround = 16;
  Picture picture = prompt_marks(prompt, size.x, size.y);
  std::vector<std::uint8_t> rgba(4 * picture.grey.size(), kGround);
  display::Writing writing;
  writing.write({.visible = true, .hint = prompt.text, .upright = look.upright}, size);
  for (const display::Writing::Panel& panel : writing.panels())
    display::Writing::lay_over(panel, rgba.data(), 4 * static_cast<std::size_t>(size.x), glm::ivec2(0), false);
  for (std::size_t i = 0; i < picture.grey.size(); ++i)
    if (picture.grey[i] == 0) picture.grey[i] = rgba[4 * i];
  return picture;
}

#ifdef TYPODONT_WINDOW
/// Window on the bench's screen, in the rig's stereo layout.
class GuideScreen {
 public:
  GuideScreen(const ScreenLook& look, int monitor) : look_(look), device_(make_device()) {
    ring_ = gpu::FrameRing::create(device_);
    display::WindowOptions window;
    window.title = "Typodont calibration";
    window.output = monitor;
    try {
      output_ = display::make_window(device_, window);
      compositor_.emplace(device_);
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~GuideScreen() { destroy(); }
  GuideScreen(const GuideScreen&) = delete;
  GuideScreen& operator=(const GuideScreen&) = delete;

  void show(const Prompt& prompt) {
    prompt_ = prompt;
    changed_ = true;
    draw();
  }
  /// Reads keys and the close button. Redraws the picture if the desktop has lost it.
  display::UserInput poll() {
    display::UserInput input = output_->poll();
    if (changed_ || output_->needs_frame()) draw();
    return input;
  }

 private:
  static gpu::Device make_device() {
    gpu::DeviceOptions options;
    options.instance_extensions = display::window_extensions();
    options.present = true;
    return gpu::Device::create(options);
  }

  void draw() {
    const auto target = output_->acquire();
    // The window is minimised or cannot be drawn now; a later call tries again.
    if (!target) return;
    ring_.wait_idle(device_);
    const bool resized = target->size != size_;
    if (resized || changed_) make_pictures(target->size);
    const VkCommandBuffer commands = ring_.begin(device_);
    if (fresh_) {
      gpu::transition(commands, pictures_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                      VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE, VK_PIPELINE_STAGE_2_COPY_BIT,
                      VK_ACCESS_2_TRANSFER_WRITE_BIT);
      const VkExtent2D extent = pictures_.options.size;
      const VkBufferImageCopy copy{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 2},
                                   .imageExtent = {extent.width, extent.height, 1}};
      vkCmdCopyBufferToImage(commands, bytes_.buffer, pictures_.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
      gpu::transition(commands, pictures_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                      VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_PIPELINE_STAGE_2_COPY_BIT,
                      VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                      VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
      fresh_ = false;
    }
    compositor_->record(commands, pictures_, look_.layout, *target, ring_.slot(), output_->first_row());
    ring_.submit(device_, target->ready, target->done);
    output_->present(std::nullopt, [this, slot = ring_.slot()] { ring_.wait(device_, slot); });
  }

  /// Makes each eye's picture in the size in which the window shows it, so that it needs no scaling.
  void make_pictures(const glm::ivec2& size) {
    const glm::ivec2 eye = display::eye_pixels_in(look_.layout, size);
    const std::size_t pixels = static_cast<std::size_t>(eye.x) * static_cast<std::size_t>(eye.y);
    if (size != size_) {
      pictures_.destroy(device_);
      bytes_.destroy(device_);
      gpu::ImageOptions image;
      image.size = {static_cast<std::uint32_t>(eye.x), static_cast<std::uint32_t>(eye.y)};
      image.layers = 2;
      image.format = image.alias = VK_FORMAT_R8G8B8A8_UNORM;
      image.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
      pictures_ = gpu::Image::create(device_, image);
      bytes_ = gpu::Buffer::create(device_, 2 * 4 * pixels, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
      size_ = size;
    }
    auto* out = bytes_.mapped<std::uint8_t>();
    for (const bool right : {false, true}) {
      Prompt seen = prompt_;
      if (look_.layout != display::Layout::kMono) seen.left_eye &= !right, seen.right_eye &= right;
      for (const unsigned char grey : prompt_picture(seen, eye, look_).grey) {
        *out++ = grey, *out++ = grey, *out++ = grey, *out++ = 255;
      }
    }
    changed_ = false;
    fresh_ = true;
  }

  void destroy() {
    // Waits without `ring_`, which would throw if the GPU is lost.
    vkDeviceWaitIdle(device_.device);
    output_.reset();
    compositor_.reset();
    pictures_.destroy(device_);
    bytes_.destroy(device_);
    ring_.destroy(device_);
    device_.destroy();
  }

  ScreenLook look_;
  gpu::Device device_;
  gpu::FrameRing ring_;
  std::unique_ptr<display::Output> output_;
  std::optional<display::Compositor> compositor_;
  gpu::Image pictures_;
  gpu::Buffer bytes_;
  glm::ivec2 size_{0};
  Prompt prompt_;
  bool changed_ = false;  // the prompt has changed since the pictures were made
  bool fresh_ = false;    // the pictures are not yet uploaded
};
#endif

/// Reads standard input line by line, with a time limit.
class Keyboard {
 public:
  std::optional<std::string> line(int wait_ms) {
    for (;;) {
      if (const auto end = text_.find('\n'); end != std::string::npos) {
        std::string line = text_.substr(0, end);
        text_.erase(0, end + 1);
        if (line.ends_with('\r')) line.pop_back();
        return line;
      }
      if (ended_) {
        if (!text_.empty()) return std::exchange(text_, {});
        if (wait_ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
        return std::nullopt;
      }
      pollfd watch{STDIN_FILENO, POLLIN, 0};
      if (::poll(&watch, 1, wait_ms) <= 0) return std::nullopt;
      char bytes[4096];
      const ssize_t n = ::read(STDIN_FILENO, bytes, sizeof bytes);
      if (n > 0)
        text_.append(bytes, static_cast<std::size_t>(n));
      else if (n == 0 || errno != EINTR)
        ended_ = true;
      // Cuts off lines that are longer than any valid line.
      if (text_.size() > kLongest && text_.find('\n') == std::string::npos) text_ += '\n';
    }
  }
  bool ended() const { return ended_ && text_.empty(); }
  /// Adds lines to be read before other standard input.
  void put(const std::string& lines) { text_.insert(0, lines); }

 private:
  static constexpr std::size_t kLongest = 1 << 16;
  std::string text_;
  bool ended_ = false;
};

// Parses "x y z", mm, or six joint angles, rad.
std::optional<Touch> parse_touch(const std::string& line, const ArmGeometry& arm) {
  std::vector<double> numbers;
  const char *at = line.data(), *end = line.data() + line.size();
  while (at < end) {
    if (*at == ' ' || *at == ',' || *at == '\t' || *at == '\r') {
      ++at;
      continue;
    }
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    numbers.push_back(value), at = next;
  }
  if (numbers.size() == 3) return Touch{dvec3(numbers[0], numbers[1], numbers[2]) * kMillimetre, std::nullopt};
  if (numbers.size() != 6) return std::nullopt;
  Touch touch;
  touch.reading = ArmReading{};
  std::copy(numbers.begin(), numbers.end(), touch.reading->angle.begin());
  touch.p_H = tip_position(arm, *touch.reading);
  return touch;
}

/// One calibration step, from the first prompt to the end.
class Guide {
 public:
  Guide(GuidedCapture& capture, const GuideOptions& options) : capture_(capture), options_(options) {
    if (!options.audio.empty()) voice_.emplace(options.audio);
    look_ = look_of(capture, options.rig);
    if (options.hand.empty()) return;
    open_screen();
    hand_.emplace(options);
    log::info(
        "{}: hold the tip still and press the pedal, or Enter; u and Enter takes the last touch back, d solves, s "
        "skips the step, q stops",
        hand_->info().model);
  }

  std::string device() const {
    if (!hand_) return {};
    const haptics::DeviceInfo& info = hand_->info();
    return info.serial.empty() ? info.model : info.model + " " + info.serial;
  }

  GuideEnd run() {
    if (capture_.taken() > 0) log::info("continuing after {} touches", capture_.taken());
    cue(Cue::kReady);
    ask("");
    while (!end_) {
      // Read ended() before take(): in the other order, the hand's last touch could be lost.
      const bool hand_ended = hand_ && hand_->ended();
      if (hand_) {
        if (const auto press = hand_->take()) answer(*press);
      }
      if (end_) break;
      // After a touch was confirmed by key, the next key is read only when take() has returned the result of the touch.
      if (waiting_ && !hand_ended)
        std::this_thread::sleep_for(1ms);
      else if (const auto line = keys_.line(hand_ ? 4 : 1000))
        obey(*line);
      else if (hand_ended)
        lose_hand();
      else if (!hand_ && keys_.ended())
        end_ = GuideEnd::kStop;
      look_at_screen();
      if (voice_) voice_->advance();
    }
    if (voice_) voice_->finish();
    return *end_;
  }

 private:
  void open_screen() {
    if (!options_.window || (options_.monitor < 0 && !display::has_desktop())) return;
#ifdef TYPODONT_WINDOW
    try {
      screen_.emplace(look_, options_.monitor);
    } catch (const std::exception& e) {
      if (options_.monitor >= 0) throw;
      log::warn("no prompts on the screen: {}", e.what());
    }
#else
    if (options_.monitor >= 0)
      throw Error("--monitor", "", "a build without windows", "a build with TYPODONT_WINDOW=ON");
#endif
  }

  void look_at_screen() {
#ifdef TYPODONT_WINDOW
    if (!screen_ || end_) return;
    const display::UserInput input = screen_->poll();
    if (input.close) end_ = GuideEnd::kStop;
    namespace keys = display::keys;
    std::string lines;
    for (const int key : input.pressed) {
      if (key == keys::kEnter || key == keys::kKeypadEnter || key == ' ') lines += "\n";
      if (key == 'U' || key == keys::kBackspace) lines += "undo\n";
      if (key == 'D') lines += "done\n";
      if (key == 'S') lines += "skip\n";
      if (key == 'Q' || key == keys::kEscape) lines += "quit\n";
    }
    keys_.put(lines);
#endif
  }

  void cue(Cue what) {
    if (voice_) voice_->play(what);
  }

  /// Shows the text `happened`, asks for the next touch, and waits for this touch.
  void ask(const std::string& happened) {
    Prompt prompt = capture_.prompt();
    if (!happened.empty()) fmt::print("{}\n", happened);
    fmt::print("{}\n", prompt.text);
    std::fflush(stdout);
    if (!happened.empty()) prompt.text += " (" + happened + ")";
    if (!options_.picture.empty()) write_picture(options_.picture, prompt_picture(prompt, {1280, 720}, look_));
#ifdef TYPODONT_WINDOW
    if (screen_) screen_->show(prompt);
#endif
    if (hand_) hand_->ready();
  }

  void add(const Touch& touch) {
    const Live live = capture_.add(touch);
    const dvec3 at = live.p_W.value_or(dvec3(0)) * 1e3;
    const std::string text = live.outlier && live.p_W
                                 ? fmt::format("{} (it lies at {:.3f}, {:.3f}, {:.3f} mm)", live.text, at.x, at.y, at.z)
                                 : live.text;
    cue(live.cue);
    if (!capture_.done()) return ask(text);
    fmt::print("{}\n", text);
    end_ = GuideEnd::kSolve;
  }

  void answer(const GuideHand::Press& press) {
    waiting_ = false;
    if (press.verdict == StillTouch::Verdict::kTaken) {
      if (capture_.step() == Step::kArm && !press.reading) {
        throw Error("--hand", "", options_.hand + ", which does not tell six joint angles, for the step arm",
                    "an arm that does; or six angles in rad a line on standard input, without --hand");
      }
      // Only open arm designs have a kinematic model.
      const bool modelled = capture_.step() == Step::kArm || options_.hand.starts_with("woodenhaptics:");
      return add({press.p_H, modelled ? press.reading : std::nullopt});
    }
    cue(Cue::kOutlier);
    const double window_ms = options_.still.window * 1e3;
    ask(press.verdict == StillTouch::Verdict::kMoved
            ? fmt::format("not taken: the tip moved {:.2f} mm within {:.0f} ms, hold it still and press again",
                          press.moved * 1e3, window_ms)
            : fmt::format("not taken: hold the tip still for {:.0f} ms first", window_ms));
  }

  void obey(const std::string& line) {
    if (line.empty()) {
      if (hand_ && !hand_->ended()) hand_->press(), waiting_ = true;
    } else if (line == "q" || line == "quit") {
      end_ = GuideEnd::kStop;
    } else if (line == "s" || line == "skip") {
      end_ = GuideEnd::kSkip;
    } else if (line == "d" || line == "done") {
      cue(Cue::kDone);
      end_ = GuideEnd::kSolve;
    } else if (line == "u" || line == "undo") {
      const bool undone = capture_.undo();
      if (undone) cue(Cue::kUndone);
      ask(undone ? "the last touch is undone" : "there is nothing to undo");
    } else if (const auto touch = parse_touch(line, capture_.bench().arm)) {
      add(*touch);
    } else {
      log::warn("standard input: found \"{}\", expected x y z in mm, six joint angles in rad, undo, done, skip or quit",
                line.substr(0, 60));
      ask("");
    }
  }

  [[noreturn]] void lose_hand() {
    if (voice_) voice_->finish();
    throw RunFailure(
        fmt::format("{}: no more samples; {} of {} touches are kept, the same command continues from there",
                    options_.hand, capture_.taken(), capture_.planned()));
  }

  GuidedCapture& capture_;
  const GuideOptions& options_;
  ScreenLook look_;
  Keyboard keys_;
  std::optional<GuideVoice> voice_;
#ifdef TYPODONT_WINDOW
  std::optional<GuideScreen> screen_;
#endif
  std::optional<GuideHand> hand_;
  std::optional<GuideEnd> end_;
  bool waiting_ = false;  // true: the user confirmed a touch by key, and hand_ has not returned it yet
};

}  // namespace

GuideEnd run_guide(GuidedCapture& capture, const GuideOptions& options, std::string* device) {
  Guide guide(capture, options);
  if (device) *device = guide.device();
  return guide.run();
}

void write_picture(const std::filesystem::path& file, const Picture& picture) {
  if (file.extension() == ".png") {
    render::Picture png{{picture.width, picture.height}, {}};
    for (const unsigned char grey : picture.grey) png.rgba.insert(png.rgba.end(), {grey, grey, grey, 255});
    return render::write_png(file, png);
  }
  std::string bytes = fmt::format("P5\n{} {}\n255\n", picture.width, picture.height);
  bytes.append(picture.grey.begin(), picture.grey.end());
  write_file_atomically(file, bytes, FileKind::kGreyPicture);
}

}  // namespace typodont
