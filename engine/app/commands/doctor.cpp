// `typodont doctor`: lists missing items of this machine, what does not work without them, and commands to add them.
#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "audio/audio_output.h"
#include "engine/app/assets.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/operator/finding.h"
#include "engine/app/picture/eye_size.h"
#include "engine/app/picture/magnify.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/picture/world.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/late_library.h"
#include "engine/base/realtime.h"
#include "engine/base/units.h"
#include "engine/gpu/device.h"
#include "engine/session/film.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// Silences standard error: libraries that search for hardware print a message for every absent device.
class QuietStandardError {
 public:
  QuietStandardError() : kept_(dup(STDERR_FILENO)) {
    const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (null >= 0) {
      dup2(null, STDERR_FILENO);
      close(null);
    }
  }
  ~QuietStandardError() {
    if (kept_ >= 0) {
      dup2(kept_, STDERR_FILENO);
      close(kept_);
    }
  }
  QuietStandardError(const QuietStandardError&) = delete;
  QuietStandardError& operator=(const QuietStandardError&) = delete;

 private:
  int kept_;
};

DoctorFinding vulkan() {
  DoctorFinding c("vulkan", "Vulkan device");
  c.required = true;
  c.without = "no picture, neither on a display nor in a file";
  c.mend = "sudo apt install libvulkan1 mesa-vulkan-drivers";
  const QuietStandardError quiet;
  bool usable = false, real = false;
  for (const gpu::DeviceInfo& device : gpu::list_devices()) {
    c.found += fmt::format("{}{}, Vulkan {}.{}.{}", c.found.empty() ? "" : "; ", device.name,
                           VK_API_VERSION_MAJOR(device.api_version), VK_API_VERSION_MINOR(device.api_version),
                           VK_API_VERSION_PATCH(device.api_version));
    const bool recent = device.api_version >= VK_API_VERSION_1_3;
    usable = usable || recent;
    real = real || (recent && !device.processor);
  }
  if (!usable) {
    c.state = PartState::kMissing;
    c.found = c.found.empty() ? "no Vulkan driver" : c.found + " (Vulkan 1.3 is needed)";
  } else if (!real) {
    c.state = PartState::kDegraded;
    c.found += " (drawn by the processor)";
    c.without = "live stereo does not reach its full rate; pictures and films are made, only slower";
    c.mend =
        "install the graphics card's driver, e.g. sudo apt install mesa-vulkan-drivers (AMD, Intel) or nvidia-driver";
  }
  return c;
}

/// Draws a molar in its mouth under a moving tool, with better and better quality levels, until a level does not reach
/// `rate` (Hz). Returns the best level that reaches `rate`, as text; empty: none.
std::string best_level(const Scene& scene, haptics::TissueVolume& tissue, display::DisplayRig rig, double rate,
                       Nanos until) {
  using namespace literals;
  rig.kind = display::DisplayKind::kOffscreen;
  rig = magnified_for(rig, tissue);
  World world(scene);
  PictureStage::Options options;
  options.hud = false;
  options.handpieces = scene.handpieces;
  const auto first = std::ranges::find(render::kQualityLadder, "fastest", &render::Quality::name);
  options.quality = *first;
  PictureStage stage(rig, scene.servo, options);
  Surroundings around = world.surroundings();
  around.lit.reset();  // computing the light in the mouth would take longer than all frames
  stage.surround(around);
  TissueView view(surface_tolerance(rig, tissue.frame().voxel, *first));
  stage.show(view.update(tissue), tissue.frame().origin);
  std::string best;
  ServoTick tick;
  tick.X_WG.p = dvec3(6.8_mm, 5.5_mm, 19.0_mm), tick.spindle = 36000;
  for (auto level = first;; --level) {
    stage.set_quality(*level);
    constexpr int kFrames = 6, kWarm = 2;  // the first kWarm frames create pipelines and are not measured
    double seconds = 0;
    for (int i = 0; i < kFrames && (i <= kWarm || now() < until); ++i) {
      tick.X_WG.p.x += 0.2_mm;
      world.place(tick);
      const Nanos began = now();
      stage.draw(world, {.debris = false, .mirror = false});
      if (i >= kWarm) seconds = std::max(seconds, to_seconds(now() - began));
    }
    if (seconds > 1 / rate) break;
    best = fmt::format("{} holds {:g} pictures a second ({:.1f} ms)", level->name, rate, 1e3 * seconds);
    if (level == render::kQualityLadder.begin() || now() > until) break;
  }
  return best;
}

/// Checks the drawing speed. `card`: true if a graphics card draws.
DoctorFinding drawing(bool card) {
  DoctorFinding c("drawing", "Picture while drilling");
  const QuietStandardError quiet;
  try {
    const Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
    haptics::TissueVolume tissue = load_tissue(scene);
    const auto measure = [&](const char* rig_name, glm::ivec2 eye, const char* size, double rate) {
      constexpr Nanos kMeasured = 3 * kNanosPerSecond;
      display::DisplayRig rig = display::load_rig(assets_folder() / "rigs" / rig_name);
      draw_eyes_at(rig, eye);
      const std::string best = best_level(scene, tissue, rig, rate, now() + kMeasured);
      if (best.empty()) c.state = PartState::kDegraded;
      c.found +=
          fmt::format("{}{}: {}", c.found.empty() ? "" : "; ", size,
                      best.empty() ? fmt::format("no level above coarse holds {:g} pictures a second", rate) : best);
    };
    measure("window.json", {1280, 720}, "window, 1280x720", 30);
    if (card) measure("closeup.json", {2064, 2208}, "headset, 2064x2208 an eye", 90);
  } catch (const std::exception& e) {
    c.state = PartState::kDegraded;
    c.found = fmt::format("not measured: {}", e.what());
  }
  c.without = "the picture jerks; the force does not";
  c.mend = card ? "use a smaller window or a faster card" : "use a smaller window, or a graphics card with its driver";
  return c;
}

DoctorFinding processor() {
  DoctorFinding c("cpu", "Processor");
  cpu_set_t set;
  CPU_ZERO(&set);
  const int cores = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
  std::ifstream info("/proc/cpuinfo");
  std::string line, model = "unknown model";
  while (std::getline(info, line)) {
    if (line.starts_with("model name")) {
      model = line.substr(std::min(line.size(), line.find(':') + 2));
      break;
    }
  }
  std::string simd = "baseline SIMD";
#if defined(__x86_64__)
  __builtin_cpu_init();
  simd = __builtin_cpu_supports("avx512f") ? "AVX-512" : __builtin_cpu_supports("avx2") ? "AVX2" : "SSE2";
#endif
  c.found = fmt::format("{} cores, {}, {}", cores, simd, model);
  if (cores < 2) {
    c.state = PartState::kDegraded;
    c.without = "the servo shares its core with everything else: late ticks";
    c.mend = "use a machine with two cores or more";
  }
  return c;
}

DoctorFinding realtime() {
  DoctorFinding c("realtime", "Real-time rights");
  if (realtime_refusal().empty()) {
    c.found = "SCHED_FIFO is allowed";
    return c;
  }
  c.state = PartState::kDegraded;
  c.found = "SCHED_FIFO is refused";
  c.without =
      "when the computer is busy, ticks are several milliseconds late and a hard surface vibrates; hands with motors "
      "then need --no-real-time";
  c.mend =
      "printf '@realtime - rtprio 95\\n@realtime - memlock unlimited\\n' | sudo tee "
      "/etc/security/limits.d/95-typodont.conf "
      "&& sudo groupadd -f realtime && sudo usermod -aG realtime $USER, then log in again";
  return c;
}

DoctorFinding locked_memory() {
  DoctorFinding c("locked_memory", "Locked memory");
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  constexpr rlim_t kEnough = rlim_t{512} << 20;
  if (geteuid() == 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= kEnough) {
    c.found =
        geteuid() == 0 || limit.rlim_cur == RLIM_INFINITY ? "unlimited" : fmt::format("{} MB", limit.rlim_cur >> 20);
    return c;
  }
  c.state = PartState::kDegraded;
  c.found = fmt::format("{} KB", limit.rlim_cur >> 10);
  c.without = "a page that was swapped out stops the servo for milliseconds";
  c.mend =
      "printf '@realtime - memlock unlimited\\n' | sudo tee -a /etc/security/limits.d/95-typodont.conf && sudo "
      "groupadd -f "
      "realtime && sudo usermod -aG realtime $USER, then log in again";
  return c;
}

DoctorFinding clock_speed() {
  DoctorFinding c("cpu_frequency", "Processor clock");
  const std::string governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  const std::string source = first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  c.found = fmt::format("governor {}, clock source {}", governor.empty() ? "not adjustable" : governor,
                        source.empty() ? "unknown" : source);
  if (governor == "powersave" || governor == "conservative") {
    c.state = PartState::kDegraded;
    c.without = "the servo's core enters deep sleep states and wakes late";
    c.mend = "sudo cpupower frequency-set -g performance";
  }
  return c;
}

/// A known USB device, with its numbers as in the kernel's uevent file.
struct KnownDevice {
  unsigned vendor, product;  // USB numbers; product 0 means any product
  const char* name;
};
constexpr KnownDevice kKnown[] = {
    {0x1234, 0x0006, "WoodenHaptics"},
    {0x16c0, 0x0486, "WoodenHaptics (Teensy)"},
    {0x046d, 0xc626, "SpaceNavigator"},
    {0x256f, 0, "3Dconnexion SpaceMouse"},
    {0x05f3, 0x00ff, "foot pedal (Infinity)"},
    {0x0c45, 0x7403, "foot pedal"},
    {0x0c45, 0x7404, "foot pedal"},
    {0x3553, 0xb001, "foot pedal"},
    {0x413d, 0x2107, "foot pedal"},
    {0x1a86, 0xe026, "foot pedal"},
};

DoctorFinding hid() {
  DoctorFinding c("hid", "Arms, SpaceMouse, pedals");
  c.without = "no force, no 6-axis mouse, no pedal: the mouse, a script or a simulated hand is used";
  std::error_code code;
  std::vector<std::string> known, refused;
  unsigned nodes = 0;
  for (const auto& entry : fs::directory_iterator("/sys/class/hidraw", code)) {
    ++nodes;
    const std::string node = "/dev/" + entry.path().filename().string();
    unsigned bus = 0, vendor = 0, product = 0;
    std::ifstream uevent(entry.path() / "device/uevent");
    for (std::string line; std::getline(uevent, line);) {
      if (line.starts_with("HID_ID=")) std::sscanf(line.c_str(), "HID_ID=%x:%x:%x", &bus, &vendor, &product);
    }
    for (const KnownDevice& device : kKnown) {
      if (device.vendor != vendor || (device.product != 0 && device.product != product)) continue;
      (access(node.c_str(), R_OK | W_OK) == 0 ? known : refused).push_back(fmt::format("{} ({})", device.name, node));
    }
  }
  for (const auto& entry : fs::directory_iterator("/dev/serial/by-id", code)) {
    const std::string name = entry.path().filename().string();
    if (name.find("Teensy") == std::string::npos) continue;
    (access(entry.path().c_str(), R_OK | W_OK) == 0 ? known : refused).push_back(fmt::format("Teensy ({})", name));
  }
  bool rules = false;
  for (const char* folder : {"/etc/udev/rules.d", "/usr/lib/udev/rules.d", "/lib/udev/rules.d"}) {
    for (const auto& entry : fs::directory_iterator(folder, code)) {
      rules = rules || entry.path().filename().string().find("typodont") != std::string::npos;
    }
  }
  const std::string write_rules = fmt::format(
      "printf 'SUBSYSTEM==\"hidraw\", ATTRS{{idVendor}}==\"%s\", TAG+=\"uaccess\"\\n' 1234 16c0 046d 256f 05f3 0c45 "
      "3553 413d "
      "1a86 | sudo tee /etc/udev/rules.d/70-typodont.rules && sudo udevadm control --reload && sudo udevadm trigger");
  if (!refused.empty()) {
    c.state = PartState::kDegraded;
    c.found = fmt::format("without permission: {}", fmt::join(refused, ", "));
    c.mend = refused.front().starts_with("Teensy") ? "sudo usermod -aG dialout $USER, then log in again" : write_rules;
  } else if (!known.empty()) {
    c.found = fmt::format("{}", fmt::join(known, ", "));
  } else {
    c.state = PartState::kMissing;
    c.found = fmt::format("no device that Typodont knows ({} HID devices in all{})", nodes,
                          rules ? ", udev rules are there" : "");
    c.mend = rules || geteuid() == 0 ? "connect one" : "connect one; so that it may be used: " + write_rules;
  }
  return c;
}

DoctorFinding audio() {
  DoctorFinding c("audio", "Sound output");
  c.without = "no live sound: it is written to a WAV file instead";
#ifdef TYPODONT_WITH_PORTAUDIO
  setenv("JACK_NO_START_SERVER", "1", 1);  // the check must not start a sound server
  try {
    const std::vector<audio::AudioDevice> outputs = audio::audio_devices();
    const auto fallback = std::ranges::find_if(outputs, &audio::AudioDevice::is_default);
    if (fallback != outputs.end()) {
      c.found = fmt::format("{} outputs; default: {}, {:.0f} Hz, latency from {:.0f} ms", outputs.size(),
                            fallback->name, fallback->sample_rate, fallback->latency * 1e3);
      return c;
    }
    c.found = "no sound card";
    c.mend = "connect one; then: aplay -l; and for permission: sudo usermod -aG audio $USER";
  } catch (const std::runtime_error&) {
    c.found = "PortAudio does not start";
    c.mend = "sudo apt install libportaudio2 alsa-utils";
  }
  c.state = PartState::kMissing;
#else
  c.state = PartState::kMissing;
  c.found = "built without PortAudio";
  c.mend =
      "sudo apt install portaudio19-dev && cmake --preset release -DTYPODONT_PORTAUDIO=ON && cmake --build --preset "
      "release";
#endif
  return c;
}

DoctorFinding openxr() {
  DoctorFinding c("openxr", "OpenXR runtime");
  c.without = "no head-mounted display: window, mirror bench and offscreen work";
  c.mend = "install SteamVR, or Monado (monado.freedesktop.org), and start it; or set XR_RUNTIME_JSON to its JSON file";
  std::vector<fs::path> places;
  const std::string chosen = environment("XR_RUNTIME_JSON");
  if (!chosen.empty()) {
    places = {chosen};
  } else {
    const std::string config = environment("XDG_CONFIG_HOME"), home = environment("HOME");
    if (!config.empty()) places.emplace_back(fs::path(config) / "openxr/1/active_runtime.json");
    if (!home.empty()) places.emplace_back(fs::path(home) / ".config/openxr/1/active_runtime.json");
    for (const char* folder : {"/etc/xdg", "/usr/local/etc", "/etc", "/usr/local/share", "/usr/share"}) {
      places.emplace_back(fs::path(folder) / "openxr/1/active_runtime.json");
    }
  }
  for (const fs::path& place : places) {
    std::ifstream in(place);
    if (!in) continue;
    const auto json = nlohmann::json::parse(in, nullptr, /*allow_exceptions=*/false);
    const auto runtime = json.is_object() ? json.find("runtime") : json.end();
    if (json.is_discarded() || !json.is_object() || runtime == json.end() || !runtime->is_object() ||
        !runtime->contains("library_path") || !(*runtime)["library_path"].is_string()) {
      c.state = PartState::kDegraded;
      c.found = fmt::format("{}: not a runtime's description", place.string());
      return c;
    }
    fs::path library = (*runtime)["library_path"].get<std::string>();
    // A name without folder is found by the dynamic loader. A relative path begins at the folder of the JSON file.
    if (library.has_parent_path() && library.is_relative()) library = place.parent_path() / library;
    std::error_code code;
    if (library.has_parent_path() && !fs::exists(library, code)) {
      c.state = PartState::kDegraded;
      c.found = fmt::format("{} names {}, which is not there", place.string(), library.string());
      return c;
    }
    c.found = fmt::format("{} ({})", library.string(), place.string());
    return c;
  }
  c.state = PartState::kMissing;
  c.found = chosen.empty() ? "none is active" : fmt::format("XR_RUNTIME_JSON={} is not readable", chosen);
  return c;
}

DoctorFinding display() {
  DoctorFinding c("display", "Display");
  const std::string wayland = environment("WAYLAND_DISPLAY"), x11 = environment("DISPLAY");
  if (!wayland.empty()) {
    c.found = "Wayland (" + wayland + ")";
    return c;
  }
  if (!x11.empty()) {
    c.found = "X11 (" + x11 + ")";
    std::error_code code;
    const std::string number =
        x11.substr(1, x11.find('.') == std::string::npos ? std::string::npos : x11.find('.') - 1);
    if (x11[0] != ':' || fs::exists("/tmp/.X11-unix/X" + number, code)) return c;
    c.state = PartState::kDegraded;
    c.found += ", but no server answers there";
  } else {
    c.state = PartState::kMissing;
    c.found = "neither WAYLAND_DISPLAY nor DISPLAY is set";
  }
  c.without = "no window: pictures and films are drawn offscreen";
  c.mend = "run it inside a desktop session; over ssh: ssh -X; for a try without a screen: xvfb-run typodont run SCENE";
  return c;
}

DoctorFinding encoder() {
  DoctorFinding c("ffmpeg", "Film encoder");
  if (const auto path = session::find_ffmpeg()) {
    c.found = path->string();
    return c;
  }
  c.state = PartState::kMissing;
  c.found = "no ffmpeg in PATH";
  c.without = "no session.mp4; pictures, sound and report are made";
  c.mend = "sudo apt install ffmpeg";
  return c;
}

/// Loads the libraries that the program otherwise loads at their first use.
DoctorFinding libraries() {
  DoctorFinding c("libraries", "Libraries loaded on use");
  c.without = "the parts of the program that use these libraries";
  std::set<std::string> files, packages;
  for (LateLibrary* library : LateLibrary::all()) {
    try {
      library->load();
      files.insert(library->file());
    } catch (const Error& missing) {
      packages.insert(library->package());
      c.found += (c.found.empty() ? "" : "; ") + std::string(missing.what());
    }
  }
  if (packages.empty()) {
    c.found = fmt::format("{}", fmt::join(files, ", "));
  } else {
    c.state = PartState::kMissing;
    c.mend = fmt::format("sudo apt install {}", fmt::join(packages, " "));
  }
  return c;
}

DoctorFinding disk() {
  DoctorFinding c("disk", "Disk space");
  c.required = true;
  struct statvfs space {};
  std::error_code code;
  const fs::path here = fs::current_path(code);
  if (code || statvfs(here.c_str(), &space) != 0) {
    c.state = PartState::kDegraded;
    c.found = "unknown";
    c.without = "a recording may end when the disk is full";
    c.mend = "df -h .";
    return c;
  }
  const double gb = static_cast<double>(space.f_bavail) * static_cast<double>(space.f_frsize) * 1e-9;
  c.found = fmt::format("{:.1f} GB free in {}", gb, here.string());
  if (gb < 2) {
    c.state = gb < 0.1 ? PartState::kMissing : PartState::kDegraded;
    c.without = "recordings (about 1 GB an hour) and films end when the disk is full";
    c.mend = "df -h . && sudo apt clean";
  }
  return c;
}

void run(bool json) {
  std::vector<DoctorFinding> checks{vulkan()};
  if (checks.front().state != PartState::kMissing) checks.push_back(drawing(checks.front().state == PartState::kOk));
  for (const auto check :
       {processor, realtime, locked_memory, clock_speed, hid, audio, openxr, display, encoder, libraries, disk})
    checks.push_back(check());
  for (DoctorFinding& c : checks)
    if (c.state == PartState::kOk) c.without = c.mend = "";
  std::string refusal;
  for (const DoctorFinding& c : checks) {
    if (c.severity() == DoctorFinding::Severity::kFailure)
      refusal += fmt::format("{}{}: {}", refusal.empty() ? "" : "; ", c.name, c.found);
  }
  if (json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const DoctorFinding& c : checks) {
      list.push_back({{"id", c.id},
                      {"name", c.name},
                      {"state", name_of(c.state)},
                      {"found", c.found},
                      {"without", c.without},
                      {"mend", c.mend},
                      {"required", c.required}});
    }
    const nlohmann::ordered_json result = {
        {"version", TYPODONT_VERSION}, {"runs_offscreen", refusal.empty()}, {"checks", list}};
    fmt::print("{}\n", result.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    for (const DoctorFinding& c : checks) {
      fmt::print("{:<9} {:<25} {}\n", name_of(c.state), c.name, c.found);
      if (!c.without.empty())
        fmt::print("{:36}{}: {}\n", "", c.state == PartState::kMissing ? "without it" : "as it is", c.without);
      if (!c.mend.empty()) fmt::print("{:36}remedy: {}\n", "", c.mend);
    }
    if (refusal.empty()) fmt::print("\nTypodont runs on this machine.\n");
  }
  std::fflush(stdout);
  if (!refusal.empty()) throw RunFailure("Typodont cannot run on this machine, not even offscreen: " + refusal);
}

}  // namespace

void add_doctor_command(cli::Command& app) {
  cli::Command* command =
      app.add_command("doctor", "Report what this computer has, what is missing, and the command that installs it");
  const auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "print the findings as JSON");
  command->footer(
      "Exit status: 0 when Typodont can run here, at least offscreen; else 1.\nExample:\n  typodont doctor --json");
  command->callback([json] { run(*json); });
}

}  // namespace typodont
