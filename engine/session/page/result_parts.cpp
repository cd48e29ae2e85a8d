#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>

#include "engine/base/base64.h"
#include "engine/base/units.h"
#include "engine/session/page/model_colors.h"
#include "engine/session/page/page.h"
#include "engine/session/page/section.h"
#include "session_files.h"

namespace typodont::session {

namespace {

/// Order of the pictures: "before", "during", "after", others.
int rank_of(const SessionPicture& p) {
  return p.name.starts_with("before") ? 0 : p.name.starts_with("during") ? 1 : p.name.starts_with("after") ? 2 : 3;
}

/// Run-length encoding of the labels: tissue in the upper four bits, length in the lower twelve.
std::vector<std::uint16_t> runs_of(const std::vector<Tissue>& labels) {
  constexpr std::size_t kLongestRun = 4095;
  static_assert(kTissueCount <= 16);
  std::vector<std::uint16_t> runs;
  for (std::size_t i = 0; i < labels.size();) {
    std::size_t end = i + 1;
    while (end < labels.size() && labels[end] == labels[i] && end - i < kLongestRun) ++end;
    runs.push_back(static_cast<std::uint16_t>(static_cast<std::size_t>(labels[i]) << 12 | (end - i)));
    i = end;
  }
  return runs;
}

const ScoreItem* item_of(const Score& score, const std::string& name) {
  const auto it =
      std::find_if(score.items.begin(), score.items.end(), [&](const ScoreItem& i) { return i.name == name; });
  return it == score.items.end() ? nullptr : &*it;
}

}  // namespace

Page::Views Page::views() const {
  const dvec3 axis = options_.preparation ? options_.preparation->axis_W : dvec3(0, 0, 1);
  const dvec3 other = std::abs(axis.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 0, 1);
  const dvec3 right = glm::normalize(other - glm::dot(other, axis) * axis), away = glm::cross(axis, right);
  return {{-axis, away}, {away, axis}, {-right, axis}, angled_view(axis), right};
}

std::string Page::view_text(const ModelView& view, const char* name) const {
  const dvec3 axis = options_.preparation ? options_.preparation->axis_W : dvec3(0, 0, 1);
  const std::string_view side = tooth_ ? side_seen(*tooth_, axis, view.look_W) : std::string_view();
  return say(fmt::format("view.{}", side.empty() ? name : side));
}

void Page::result_views() {
  if (!options_.result) return;
  const ResultModel& model = *options_.result;
  const Views at = views();
  begin_section("form", "form", Length::kLong);
  if (has_ideal()) {
    put("<p class=\"soft\">{}</p>\n", say("form_note"));
    worst_places();
  }
  put("<div class=\"pictures\">\n");
  const auto picture = [&](const ModelView& view, bool difference, const std::string& caption) {
    put("<figure><img alt=\"{}\" src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
        escaped(say("picture.alt", caption)), base64(draw_model(model, view, {420, 320}, difference)),
        escaped(caption));
  };
  picture(at.above, false, view_text(at.above, "above"));
  picture(at.angled, false, view_text(at.angled, "angled"));
  if (has_ideal()) {
    const auto map = [&](const ModelView& view, const char* name) {
      picture(view, true, fmt::format("{}: {}", say("difference"), view_text(view, name)));
    };
    map(at.above, "above");
    map(at.front, "front");
    map(at.side, "side");
    map(at.angled, "angled");
  }
  put("</div>\n");
  if (has_ideal()) color_bar();
  viewer(at);
  sections(at);
  end_section();
}

void Page::worst_places() {
  if (!input_.cavity) return;
  const CavityMeasures& c = *input_.cavity;
  const auto say_place = [&](const char* key, const Place& place) {
    if (!(place.depth > 0)) return;
    put("<p>{}</p>\n", say(key, quantity(place.depth * 1e3, "mm"), place_words(place.p_W)));
  };
  say_place("worst_over", c.over);
  say_place("worst_under", c.under);
}

void Page::color_bar() {
  const auto css = [](std::size_t i) {
    const auto& c = kDifferenceColors[i];
    return fmt::format("rgb({},{},{})", c[0], c[1], c[2]);
  };
  const std::string full = number(kFullColor * 1e3, 1);
  put("<div class=\"colorbar\" role=\"img\" aria-label=\"{0}\"><i "
      "style=\"background:linear-gradient(90deg,{1},{2},{3})\"></i>"
      "<span>−{4} mm {5}</span><span>0</span><span>+{4} mm {6}</span></div>\n",
      escaped(say("colorbar_alt")), css(2), css(1), css(0), full, say("too_deep"), say("too_much"));
}

void Page::viewer(const Views& at) {
  put("<h3>{}</h3>\n<noscript><p class=\"soft\">{}</p></noscript>\n<div id=\"viewer\" hidden>\n<div class=\"buttons\" "
      "role=\"group\" "
      "aria-label=\"{}\">",
      say("turn"), say("no_script"), say("show"));
  const auto mode = [&](const char* name, const char* key) {
    put("<button type=\"button\" data-mode=\"{}\" aria-pressed=\"false\">{}</button>", name, say(key));
  };
  mode("result", "form");
  if (has_ideal()) mode("difference", "difference");
  if (options_.ideal) mode("ideal", "ideal");
  put("</div>\n<div class=\"buttons\" role=\"group\" aria-label=\"{}\">", say("view"));
  for (const auto& [name, view] : {std::pair{"above", &at.above}, std::pair{"front", &at.front},
                                   std::pair{"side", &at.side}, std::pair{"angled", &at.angled}})
    put("<button type=\"button\" data-look=\"{}\">{}</button>", name, view_text(*view, name));
  put("<button type=\"button\" data-look=\"reset\">{}</button>\n<label>{} <input type=\"range\" name=\"cut\" min=\"5\" "
      "max=\"100\" "
      "value=\"100\"></label></div>\n<canvas tabindex=\"0\" role=\"img\" aria-label=\"{}\"></canvas>\n<p "
      "class=\"soft\">{}</p>\n"
      "<p aria-live=\"polite\" class=\"hush\"></p>\n</div>\n",
      say("reset"), say("cut_open"), escaped(say("viewer_alt")), say("viewer_keys"));
  put("<script type=\"application/json\" id=\"model-data\">{}</script>\n<script>{}</script>\n", model_data(at),
      kViewerScript);
}

std::string Page::model_data(const Views& at) const {
  std::vector<const ResultModel*> models{&*options_.result};
  if (options_.ideal) models.push_back(&*options_.ideal);
  glm::vec3 lo(1e9f), hi(-1e9f);
  for (const ResultModel* m : models) {
    for (const auto& v : m->vertices) lo = glm::min(lo, v.p_W), hi = glm::max(hi, v.p_W);
  }
  const glm::vec3 middle = 0.5f * (lo + hi), extent = hi - lo;
  const float largest = std::max({extent.x, extent.y, extent.z, 1e-6f}), step = largest / 2 / 32767;
  const auto raw = []<class T>(const std::vector<T>& values) {
    const auto* p = reinterpret_cast<const unsigned char*>(values.data());
    return base64({p, values.size() * sizeof(T)});
  };
  const auto vec = [](const dvec3& v) { return fmt::format("[{:.5f},{:.5f},{:.5f}]", v.x, v.y, v.z); };
  std::vector<std::string> meshes;
  for (const ResultModel* m : models) {
    std::vector<std::int16_t> position;
    std::vector<std::int8_t> normal, off;
    std::vector<std::uint8_t> tissue;
    for (const auto& v : m->vertices) {
      for (int k = 0; k < 3; ++k) {
        position.push_back(static_cast<std::int16_t>(std::lround((v.p_W[k] - middle[k]) / step)));
        normal.push_back(static_cast<std::int8_t>(std::lround(127 * std::clamp(v.n[k], -1.0f, 1.0f))));
      }
      tissue.push_back(static_cast<std::uint8_t>(v.tissue));
      off.push_back(
          static_cast<std::int8_t>(std::lround(127 * std::clamp(v.off / static_cast<float>(kFullColor), -1.0f, 1.0f))));
    }
    std::vector<std::uint32_t> index;
    for (const auto& t : m->triangles) index.insert(index.end(), t.begin(), t.end());
    // Offset and scale convert integer positions to label indices.
    const TissueLabels& labels = m->labels;
    const double sample = labels.frame.voxel > 0 ? labels.frame.voxel : 1;
    meshes.push_back(fmt::format(
        "{{\"position\":\"{}\",\"normal\":\"{}\",\"tissue\":\"{}\",\"off\":\"{}\",\"index\":\"{}\",\"labels\":{{"
        "\"size\":[{},{},{}],\"offset\":{},\"scale\":{:.6g},\"runs\":\"{}\"}}}}",
        raw(position), raw(normal), raw(tissue), raw(off), raw(index), labels.size.x, labels.size.y, labels.size.z,
        vec((dvec3(middle) - labels.frame.origin) / sample), static_cast<double>(step) / sample,
        raw(runs_of(labels.tissue))));
  }
  const auto view = [&](const ModelView& v) {
    return fmt::format("{{\"back\":{},\"up\":{}}}", vec(-v.look_W), vec(v.up_W));
  };
  std::vector<std::string> tissues, difference;
  for (const auto& c : kTissueColors) tissues.push_back(fmt::format("[{},{},{}]", c[0], c[1], c[2]));
  for (const auto& c : kDifferenceColors) difference.push_back(fmt::format("[{},{},{}]", c[0], c[1], c[2]));
  // The view rotates about the middle of the grid.
  glm::vec3 focus(0);
  if (options_.preparation) {
    const Preparation& p = *options_.preparation;
    focus = (glm::vec3(p.frame.to_world(0.5 * dvec3(p.before.size))) - middle) / step;
  }
  return fmt::format(
      "{{\"has_ideal\":{},\"focus\":{},\"extent\":{:.6g},\"step\":{:.6g},\"tissues\":[{}],\"difference\":[{}],\"view\":"
      "{{"
      "\"above\":{},\"front\":{},\"side\":{},\"angled\":{},\"slice\":{}}},\"defects\":{},\"meshes\":[{}]}}",
      has_ideal() ? "true" : "false", vec(dvec3(focus)), glm::length(extent), step, fmt::join(tissues, ","),
      fmt::join(difference, ","), view(at.above), view(at.front), view(at.side), view(at.angled), vec(-at.front.look_W),
      stroke_data(dvec3(middle), static_cast<double>(step)), fmt::join(meshes, ","));
}

void Page::sections(const Views& at) {
  if (!options_.preparation) return;
  // Sections go through the point of largest deviation, or through the middle of the grid.
  const Preparation& p = *options_.preparation;
  dvec3 through = p.frame.to_world(0.5 * dvec3(p.before.size));
  if (input_.cavity) {
    const Place &over = input_.cavity->over, &under = input_.cavity->under;
    const Place& worst = over.depth > under.depth ? over : under;
    if (worst.depth > 0) through = worst.p_W;
  }
  const auto section = [&](const dvec3& along_W) {
    const auto side = [&](const dvec3& direction) {  // name of the tooth's side that faces `direction`
      const std::string_view name = tooth_ ? side_seen(*tooth_, p.axis_W, -direction) : std::string_view();
      return name.empty() ? std::string() : say(fmt::format("place.side.{}", name));
    };
    return section_svg(p, through, along_W, say("section_alt"), {side(-along_W), side(along_W)});
  };
  const std::string front = section(at.to_right), side = section(glm::cross(p.axis_W, at.to_right));
  if (front.empty() && side.empty()) return;
  put("<h3>{}</h3>\n<p class=\"soft\">{}</p>\n<div class=\"pictures\">\n", say("sections"), say("sections_note"));
  for (const std::string& svg : {front, side}) {
    if (!svg.empty()) put("<figure>{}</figure>\n", svg);
  }
  put("</div>\n<ul class=\"legend\" aria-hidden=\"true\"><li class=\"k-was\">{}</li><li class=\"k-is\">{}</li>",
      say("before"), say("form"));
  if (has_ideal()) put("<li class=\"k-ideal\">{}</li>", say("ideal"));
  put("</ul>\n");
}

std::vector<SessionPicture> Page::all_pictures() const {
  std::vector<SessionPicture> all;
  if (session_.result()) all = session_.result()->pictures;
  for (const SessionPicture& p : options_.more_pictures) {
    std::erase_if(all, [&](const SessionPicture& q) { return q.name == p.name; });
    all.push_back(p);
  }
  std::stable_sort(all.begin(), all.end(), [](const SessionPicture& a, const SessionPicture& b) {
    return std::pair(rank_of(a), a.name) < std::pair(rank_of(b), b.name);
  });
  return all;
}

void Page::pictures() {
  const auto all = all_pictures();
  if (all.empty()) return;
  begin_section("pictures", "pictures", Length::kLong);
  put("<div class=\"pictures\">\n");
  for (const SessionPicture& p : all) {
    const std::string key = "picture." + p.name.substr(0, p.name.find('_'));
    const std::string caption = !p.title.empty() ? p.title : has_text(key) ? say(key) : p.name;
    put("<figure><img alt=\"{}\" src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
        escaped(say("picture.alt", caption)), base64(p.png), escaped(caption));
  }
  put("</div>\n");
  end_section();
}

void Page::items() {
  begin_section("items", "items", Length::kLong);
  begin_table("items",
              {say("item"), say("points"), say("value"), say("target"), say("tolerance"),
               fmt::format("{}<br>{}", say("source"), say("guarantee"))},
              say("items_note"), 5);
  const auto guarantee = [&](const ScoreItem& item) {
    put("{}</td></tr>\n", say(item.basis == Basis::kHand                                       ? "guarantee.hand"
                              : options_.verification.state != Verification::State::kIdentical ? "guarantee.none"
                              : item.basis == Basis::kTicks                                    ? "guarantee.ticks"
                                                                                               : "guarantee.replay"));
  };
  const auto points = [&](double value) { return number(printed_points(value), 1); };
  // Sorts the score's items by weight.
  std::vector<ScoreItem> order(score_.items);
  std::ranges::stable_sort(order, std::greater(), &ScoreItem::weight);
  double sum = 0;
  for (const ScoreItem& item : order) {
    sum += item.points;
    put("<tr><th scope=\"row\">{}</th><td class=\"points\">", name_of_item(item.name));
    const bool counted = item.full > 0 || item.critical;
    if (counted) {
      const bool missed = score_.missed(item);
      put("{}", marked(fmt::format("{} / {}", points(item.points), points(item.full)), missed));
      if (item.full > 0) gauge(item.points / item.full, missed);
    } else {
      put("{}", say("not_counted"));
    }
    put("</td><td>{}</td>", std::isnan(item.value) ? say("not_there") : quantity(item.value, item.unit));
    if (counted) {
      // The source of a default rule is English text, which is also its key in the text catalogue.
      put("<td>{}</td><td>{}</td><td class=\"text source\">{}<br>", target(item), quantity(item.tolerance, item.unit),
          escaped(text(item.source, language)));
    } else {
      put("<td></td><td></td><td class=\"text source\">");
    }
    guarantee(item);
  }
  put("</tbody>\n");
  if (score_.counts()) {
    const auto foot_row = [&](const char* key, const std::string& value) {
      put("<tr><th scope=\"row\">{}</th><td class=\"points\">{}</td><td></td><td></td><td></td><td></td></tr>",
          say(key), value);
    };
    put("<tfoot>");
    const std::string full = number(score_.full, 0);
    const double percent = 100 * score_.completion;
    foot_row("points_sum", fmt::format("{} / {}", points(sum), full));
    foot_row("completion", fmt::format("× {} %", number(printed_points(percent), percent < 100 ? 1 : 0)));
    foot_row("score", marked(fmt::format("{} / {}", points(score_.points), full), !score_.passed()));
    put("</tfoot>\n");
  }
  put("</table></div>\n");
  end_section();
}

void Page::comparison() {
  if (!compares()) return;
  struct Column {
    std::string title;
    const Score* score;
  };
  std::vector<Column> columns{{say("this_session"), &score_}};
  if (!options_.earlier.empty()) {
    const SessionSummary& last = options_.earlier.back();
    columns.push_back({say("last_session"), &last.score});
    const auto best = std::max_element(options_.earlier.begin(), options_.earlier.end(),
                                       [](const auto& a, const auto& b) { return a.score.points < b.score.points; });
    columns.push_back({say("best_session"), &best->score});
  }
  if (options_.expert) columns.push_back({say("expert"), &options_.expert->score});
  begin_section("comparison", "comparison", Length::kLong);
  std::vector<std::string> heads{say("item")};
  for (const Column& c : columns) heads.push_back(c.title);
  begin_table("comparison", heads, options_.earlier.empty() ? "" : say("earlier_count", options_.earlier.size()));
  for (const ScoreItem& item : score_.items) {
    if (item.weight <= 0) continue;
    put("<tr><th scope=\"row\">{}</th>", name_of_item(item.name));
    for (const Column& c : columns) {
      const ScoreItem* other = item_of(*c.score, item.name);
      put("<td>{}</td>", other ? quantity(other->value, other->unit) : "–");
    }
    put("</tr>\n");
  }
  put("</tbody>\n<tfoot><tr><th scope=\"row\">{}</th>", say("score"));
  for (const Column& c : columns) put("<td>{}</td>", total(*c.score));
  put("</tr></tfoot>\n</table></div>\n");
  if (!options_.earlier.empty()) {
    std::vector<double> values;
    for (const SessionSummary& s : options_.earlier) values.push_back(printed_points(s.score.points));
    values.push_back(printed_points(score_.points));
    put("<figure>{}<figcaption>{}</figcaption></figure>\n",
        session_plot(values, score_.pass.points,
                     say("curve_alt", say("score"), number(values.front(), 1), number(values.back(), 1)),
                     number_text()),
        say("score"));
  }
  end_section();
}

void Page::volumes() {
  begin_section("volumes", "volumes");
  std::vector<std::string> heads{say("tissue"), say("before"), say("removed"), say("after")};
  if (input_.ideal) heads.push_back(say("ideal"));
  if (input_.removed_hardness) heads.push_back(say("removed_hardness"));
  heads.push_back(say("share_removed"));
  begin_table("volumes", heads, say("volumes_caption"));
  // An open surface encloses no volume: the page shows a dash.
  const auto whole = [&](double mm3) { return options_.encloses_nothing ? std::string("–") : number(mm3, 2); };
  double before_sum = 0, after_sum = 0, ideal_sum = 0;
  for (std::size_t i = 1; i < kTissueCount; ++i) {
    const double before = input_.before[i] * 1e9, after = input_.after[i] * 1e9;
    const double ideal = input_.ideal ? (*input_.ideal)[i] * 1e9 : 0;
    if (before <= 0 && after <= 0 && ideal <= 0) continue;
    before_sum += before;
    after_sum += after;
    ideal_sum += ideal;
    put("<tr{}><th scope=\"row\"><span class=\"swatch s-{}\" "
        "aria-hidden=\"true\"></span>{}</th><td>{}</td><td>{}</td><td>{}</td>",
        static_cast<Tissue>(i) == Tissue::kCaries ? " class=\"key\"" : "", name_of(static_cast<Tissue>(i)),
        tissue_text(i), whole(before), number(before - after, 2), whole(after));
    if (input_.ideal) put("<td>{}</td>", number(ideal, 2));
    if (input_.removed_hardness) {
      const double hardness = (*input_.removed_hardness)[i];
      put("<td>{}</td>", hardness > 0 ? number(100 * hardness, 0) + " %" : "–");
    }
    if (before > 0 && !options_.encloses_nothing) {
      put("<td>{} %</td></tr>\n", number(100 * (before - after) / before, 1));
    } else {
      put("<td></td></tr>\n");
    }
  }
  put("</tbody>\n<tfoot><tr><th scope=\"row\">Σ</th><td>{}</td><td>{}</td><td>{}</td>", whole(before_sum),
      number(before_sum - after_sum, 2), whole(after_sum));
  if (input_.ideal) put("<td>{}</td>", number(ideal_sum, 2));
  if (input_.removed_hardness) put("<td></td>");
  put("<td></td></tr></tfoot>\n</table></div>\n");
  if (options_.encloses_nothing) put("<p>{}</p>\n", say("encloses_nothing"));
  end_section();
}

}  // namespace typodont::session
