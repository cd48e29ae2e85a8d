#include "engine/app/commands/sound_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "audio/sound_file.h"
#include "audio/spectrogram.h"
#include "engine/base/error.h"
#include "engine/display/writing.h"

namespace typodont {

namespace {

constexpr double kRange = 70;  // dB, level difference between the darkest and the brightest colour
constexpr glm::u8vec3 kGround{255, 255, 255}, kLabelColour{40, 44, 50};
constexpr double kLetters = 15;  // pixels, height of the text
constexpr int kTick = 6;         // pixels, length of a tick mark on an axis
// Margins of the plot, pixels; kTopLeft: at the left and top; kBottomRight: at the right and bottom.
constexpr glm::ivec2 kTopLeft{74, 34}, kBottomRight{18, 52};

/// Colour scale from dark violet over red to light yellow, in even steps of lightness; similar to "inferno" of Smith
/// and van der Walt (2015).
glm::u8vec3 color_of(double fraction) {
  static constexpr std::array<std::array<double, 3>, 6> kStops = {
      {{8, 6, 30}, {74, 16, 108}, {148, 38, 103}, {221, 81, 58}, {251, 164, 37}, {252, 250, 170}}};
  const double at = std::clamp(fraction, 0.0, 1.0) * (kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  glm::u8vec3 color;
  for (int k = 0; k < 3; ++k) {
    const auto c = static_cast<std::size_t>(k);
    color[k] = static_cast<std::uint8_t>(
        std::lround(kStops[i][c] + (at - static_cast<double>(i)) * (kStops[i + 1][c] - kStops[i][c])));
  }
  return color;
}

/// The distance between two axis labels: 1, 2 or 5 times a power of ten, for about `count` labels.
double step_of(double range, int count) {
  const double raw = range / count, power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double m : {1.0, 2.0, 5.0})
    if (m * power >= raw) return m * power;
  return 10 * power;
}

void put(render::Picture& p, int x, int y, const glm::u8vec3& color) {
  if (x < 0 || y < 0 || x >= p.size.x || y >= p.size.y) return;
  std::uint8_t* pixel = p.rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(p.size.x) +
                                             static_cast<std::size_t>(x));
  for (int k = 0; k < 3; ++k) pixel[k] = color[k];
}

}  // namespace

SoundPicture picture_of_sound(const std::filesystem::path& sound, double to, glm::ivec2 pixels) {
  const audio::Recording recording = audio::read_recording(sound);
  if (to > recording.rate / 2)
    throw Error(sound.string(), "", fmt::format("a rate of {:.0f} Hz", recording.rate),
                fmt::format("one of {:.0f} Hz, or a lower upper end than {:.0f} Hz", 2 * to, to));
  SoundPicture made{{pixels, {}},
                    kTopLeft,
                    pixels - kTopLeft - kBottomRight,
                    to,
                    static_cast<double>(recording.length()) / recording.rate};
  render::Picture& p = made.picture;
  p.rgba.assign(static_cast<std::size_t>(pixels.x) * static_cast<std::size_t>(pixels.y) * 4, 255);
  for (int y = 0; y < pixels.y; ++y)
    for (int x = 0; x < pixels.x; ++x) put(p, x, y, kGround);
  const glm::ivec2 lo = made.plot_lo, size = made.plot_size, hi = lo + size;  // hi: one pixel outside the plot

  // Each pixel shows the maximum of the spectrum's values that it covers, so that a thin line remains visible.
  const audio::Spectrogram s = audio::spectrogram(recording.mono(), recording.rate, static_cast<std::size_t>(size.x));
  const float loudest = *std::max_element(s.dB.begin(), s.dB.end());
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      const double from_Hz = to * (size.y - 1 - y) / size.y, to_Hz = to * (size.y - y) / size.y;
      const auto first = static_cast<std::size_t>(std::lround(from_Hz / s.f_step));
      const auto last = std::max(first, static_cast<std::size_t>(std::lround(to_Hz / s.f_step)));
      float level = -1000;
      for (std::size_t bin = first; bin <= std::min(last, s.bins - 1); ++bin)
        level = std::max(level, s.at(static_cast<std::size_t>(x), bin));
      put(p, lo.x + x, lo.y + y, color_of(1 + static_cast<double>(level - loudest) / kRange));
    }
  }

  const auto write = [&](const glm::dvec2& at, std::string_view text) {
    display::write_line(p.rgba.data(), p.size, at, kLetters, text, kLabelColour);
  };
  // Draws the tick marks of the axes with their values.
  const double f_step = step_of(to, 8), t_step = step_of(made.seconds, 10);
  for (int i = 0; i * f_step <= to * (1 + 1e-9); ++i) {
    const double f = i * f_step;
    const int y = std::min(hi.y - 1, static_cast<int>(std::lround(hi.y - f / to * size.y)));
    for (int x = lo.x - kTick; x < lo.x; ++x) put(p, x, y, kLabelColour);
    const std::string text = fmt::format("{:g}", f / 1e3);
    write({lo.x - kTick - 5 - display::text_width(text, kLetters), y + 0.35 * kLetters}, text);
  }
  for (int i = 0; i * t_step <= made.seconds * (1 + 1e-9); ++i) {
    const double t = i * t_step;
    const int x = std::min(hi.x - 1, static_cast<int>(std::lround(lo.x + t / made.seconds * size.x)));
    for (int y = hi.y; y < hi.y + kTick; ++y) put(p, x, y, kLabelColour);
    const std::string text = fmt::format("{:g}", t);
    write({x - display::text_width(text, kLetters) / 2, hi.y + kTick + 1.1 * kLetters}, text);
  }
  write({10, lo.y - 0.8 * kLetters}, "frequency (kHz)");
  const std::string seconds = "time (s)";
  write({hi.x - display::text_width(seconds, kLetters), hi.y + kTick + 2.4 * kLetters}, seconds);
  return made;
}

}  // namespace typodont
