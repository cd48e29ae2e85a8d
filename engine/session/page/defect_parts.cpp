#include "engine/session/page/page.h"

namespace typodont::session {

std::string Page::place_words(const dvec3& p_W) const {
  return tooth_ && options_.preparation
             ? place_text(place_name(*options_.preparation, *tooth_, p_W), language)
             : say("place.coordinates", number(p_W.x * 1e3, 1), number(p_W.y * 1e3, 1), number(p_W.z * 1e3, 1));
}

void Page::defects() {
  if (course_.count == 0 || !options_.preparation) return;
  begin_section("strokes", "strokes", Length::kLong);
  if (options_.defects.empty()) {
    put("<p>{}</p>\n", say("no_defects"));
    return end_section();
  }
  put("<p class=\"soft\">{}</p>\n<ol class=\"defects\">\n",
      say("strokes_note", fmt::format("<code>typodont replay {} --show --from 12.5</code>",
                                      escaped(session_.file().filename().string()))));
  const auto& tools = session_.header().tools;
  for (std::size_t d = 0; d < options_.defects.size(); ++d) {
    const Defect& defect = options_.defects[d];
    put("<li><strong>{}: {}</strong>{}", name_of_item(defect.item), quantity(defect.amount, unit_of(defect.item)),
        defect.on_tooth ? ", " + place_words(defect.p_W) : "");
    if (defect.left) put(" <span class=\"soft\">({})</span>", say("stroke_closest"));
    put("<ul>");
    for (std::size_t s = 0; s < defect.strokes.size(); ++s) {
      const DefectStroke& stroke = defect.strokes[s];
      put("<li><button type=\"button\" hidden data-stroke=\"{}.{}\" aria-label=\"{}\">▶ {} s</button> {}</li>", d, s,
          say("play_stroke", number(stroke.at.t, 1)), number(stroke.at.t, 1),
          say("stroke_line", number(stroke.from, 2), number(stroke.to, 2),
              escaped(stroke.tool < tools.size() ? tool_text(tools[stroke.tool], language) : ""),
              quantity(stroke.at.force, "N")));
    }
    put("</ul></li>\n");
  }
  put("</ol>\n");
  end_section();
}

void Page::remarks() {
  if (options_.remarks.empty()) return;
  begin_section("remarks", "remarks");
  for (const Remark& remark : options_.remarks) {
    put("<p>{}{}</p>\n<p class=\"soft\">{}{}{}</p>\n",
        remark.at ? fmt::format("<strong>{} s</strong> ", number(*remark.at, 1)) : "", escaped(remark.text),
        escaped(remark.author), remark.author.empty() || remark.written.empty() ? "" : ", ",
        remark.written.empty() ? "" : date_once_with_zone(remark.written));
  }
  end_section();
}

std::string Page::stroke_data(const dvec3& middle_W, double step) const {
  const auto at = [&](const dvec3& p_W) {
    const dvec3 p = glm::round((p_W - middle_W) / step);
    return fmt::format("{:.0f},{:.0f},{:.0f}", p.x, p.y, p.z);
  };
  const auto moment = [&](const HeadMoment& m) {
    const dvec3 axis = m.X_WG.R * dvec3(0, 0, 1);
    return fmt::format("[{:.2f},{},{:.2f},{:.2f},{:.2f},{:.2f}]", m.t, at(m.X_WG.p), axis.x, axis.y, axis.z, m.force);
  };
  std::vector<std::string> defects;
  for (const Defect& defect : options_.defects) {
    std::vector<std::string> strokes;
    for (const DefectStroke& stroke : defect.strokes) {
      std::vector<std::string> path;
      for (const HeadMoment& m : stroke.path) path.push_back(moment(m));
      strokes.push_back(fmt::format("{{\"radius\":{:.0f},\"half\":{:.0f},\"at\":{},\"path\":[{}]}}",
                                    stroke.head_radius / step, stroke.head_half / step, moment(stroke.at),
                                    fmt::join(path, ",")));
    }
    defects.push_back(fmt::format("{{\"place\":[{}],\"strokes\":[{}]}}", at(defect.p_W), fmt::join(strokes, ",")));
  }
  return fmt::format("[{}]", fmt::join(defects, ","));
}

}  // namespace typodont::session
