#include "engine/app/picture/hud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "engine/base/log.h"
#include "engine/base/units.h"

namespace typodont {

display::Hud hud(const World& world, session::Language language, render::View view) {
  std::string hint = world.notice();
  if (view == render::View::kTemperature)
    hint = fmt::format("{}{}{}", session::text("hud.temperature", language), hint.empty() ? "" : kHudGap, hint);
  return {.visible = true,
          .tool = tool_line(world, language),
          .speed_krpm = world.readout().spindle / kKrpm,
          .force = glm::length(world.readout().f_T_W),
          .hint = std::move(hint),
          .warning = warning_text(world.warning(), language),
          .words = hud_words(language)};
}

std::string warning_text(Warning warning, session::Language language) {
  constexpr std::array kKeys{"", "warning.pulp", "warning.neighbour", "warning.force", "warning.axis"};
  return warning == Warning::kNone ? "" : hud_text(language, kKeys[static_cast<std::size_t>(warning)]);
}

std::string quality_text(std::string_view level, Remedy remedy, session::Language language) {
  constexpr std::array kKeys{"quality", "quality.graphics_card", "quality.smaller_window", "quality.faster_card"};
  return hud_text(language, kKeys[static_cast<std::size_t>(remedy)],
                  session::text(fmt::format("op.quality.{}", level), language));
}

display::HudWords hud_words(session::Language language) {
  return {.rpm = std::string(session::text("hud.rpm", language)),
          .krpm = std::string(session::text("hud.krpm", language)),
          .decimal = language == session::Language::kGerman ? ',' : '.'};
}

std::string short_number(double value, int digits, session::Language language) {
  std::string text = fmt::format("{:.{}g}", value, digits);
  std::replace(text.begin(), text.end(), '.', hud_words(language).decimal);
  return text;
}

std::string tool_title(const haptics::Tool& tool, session::Language language) {
  const std::string size = short_number(tool.diameter / kMillimetre, 2, language);
  const std::string_view shape = tool.shape == haptics::HeadShape::kSphere ? "round" : name_of(tool.shape);
  return fmt::format("{} {} mm", session::tool_text(tool.name.empty() ? shape : tool.name, language), size);
}

std::string tool_line(const World& world, session::Language language) {
  const std::string title = tool_title(world.tool(), language);
  const double slower = std::round(100 * (1 - 1 / (1 + world.readout().wear)));  // %, loss of removal rate by wear
  return slower > 0 ? hud_text(language, "worn", title, slower) : title;
}

session::Language hud_language(session::Language language) {
  if (display::can_write(session::text("hud.stopped", language))) return language;
  log::warn(
      "the text over the picture is English, because the program was built without a Chinese font (Debian package "
      "fonts-wqy-microhei)");
  return session::Language::kEnglish;
}

}  // namespace typodont
