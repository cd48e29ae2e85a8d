#include "engine/app/operator/interface_window.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/display/keys.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;
namespace keys = display::keys;

// Time after an input during which every frame is drawn, for hover effects and the text cursor, s.
constexpr double kSettle = 0.25;
// Pause after a frame that is not shown. For other frames, the output limits the rate.
constexpr std::chrono::milliseconds kUnshownFrame{4};

constexpr std::array kLatinFonts = {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                                    "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
                                    "/usr/share/fonts/TTF/DejaVuSans.ttf"};
constexpr std::array kChineseFonts = {
    "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc", "/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf",
    "/usr/share/fonts/truetype/arphic/uming.ttc", "/usr/share/fonts/wenquanyi/wqy-microhei/wqy-microhei.ttc"};

/// Returns the first file that exists, because Debian, Fedora and Arch keep fonts in different folders. Null: none.
const char* first_of(std::span<const char* const> files) {
  std::error_code code;
  for (const char* file : files)
    if (fs::is_regular_file(file, code)) return file;
  return nullptr;
}

/// Sets a dark, neutral theme, so that the picture stands out. One accent colour marks usable elements.
void set_theme(float unit) {
  ImGuiStyle& s = ImGui::GetStyle();
  s = ImGuiStyle();
  const float u = unit / 16;
  s.WindowPadding = {12 * u, 12 * u};
  s.FramePadding = {9 * u, 5 * u};
  s.ItemSpacing = {8 * u, 8 * u};
  s.ItemInnerSpacing = {8 * u, 6 * u};
  s.ScrollbarSize = 12 * u;
  s.GrabMinSize = 14 * u;
  s.WindowRounding = 0;
  s.ChildRounding = s.PopupRounding = 6 * u;
  s.FrameRounding = s.GrabRounding = s.ScrollbarRounding = 5 * u;
  s.WindowBorderSize = 0;
  s.ChildBorderSize = 0;
  s.FrameBorderSize = 0;
  s.PopupBorderSize = 1;
  s.SelectableTextAlign = {0, 0.5f};
  const auto grey = [](float v, float a = 1) { return ImVec4(v, v * 1.01f, v * 1.03f, a); };
  const ImVec4 accent(0.33f, 0.62f, 0.70f, 1), bright(0.42f, 0.74f, 0.82f, 1);
  const auto with = [](ImVec4 c, float a) { return ImVec4(c.x, c.y, c.z, a); };
  ImVec4* c = s.Colors;
  c[ImGuiCol_Text] = grey(0.90f);
  c[ImGuiCol_TextDisabled] = grey(0.56f);
  c[ImGuiCol_WindowBg] = grey(0.095f);
  c[ImGuiCol_ChildBg] = grey(0.125f);
  c[ImGuiCol_PopupBg] = grey(0.14f);
  c[ImGuiCol_Border] = grey(0.24f);
  c[ImGuiCol_FrameBg] = grey(0.19f);
  c[ImGuiCol_FrameBgHovered] = grey(0.23f);
  c[ImGuiCol_FrameBgActive] = grey(0.26f);
  c[ImGuiCol_ScrollbarBg] = grey(0, 0);
  c[ImGuiCol_ScrollbarGrab] = grey(0.26f);
  c[ImGuiCol_ScrollbarGrabHovered] = grey(0.32f);
  c[ImGuiCol_ScrollbarGrabActive] = grey(0.38f);
  c[ImGuiCol_CheckMark] = bright;
  c[ImGuiCol_SliderGrab] = accent;
  c[ImGuiCol_SliderGrabActive] = bright;
  c[ImGuiCol_Button] = grey(0.22f);
  c[ImGuiCol_ButtonHovered] = grey(0.28f);
  c[ImGuiCol_ButtonActive] = grey(0.33f);
  c[ImGuiCol_Header] = with(accent, 0.32f);
  c[ImGuiCol_HeaderHovered] = with(accent, 0.22f);
  c[ImGuiCol_HeaderActive] = with(accent, 0.45f);
  c[ImGuiCol_Separator] = grey(0.22f);
  c[ImGuiCol_PlotLines] = accent;
  c[ImGuiCol_PlotHistogram] = accent;
  c[ImGuiCol_TableHeaderBg] = grey(0.16f);
  c[ImGuiCol_TableBorderLight] = grey(0.2f);
  c[ImGuiCol_TableRowBgAlt] = grey(1, 0.02f);
  c[ImGuiCol_TextSelectedBg] = with(accent, 0.4f);
  c[ImGuiCol_NavHighlight] = bright;
  c[ImGuiCol_ModalWindowDimBg] = ImVec4(0, 0, 0, 0.55f);
}

gpu::Device make_device(bool validation) {
#ifdef TYPODONT_WINDOW
  const auto extensions = display::window_extensions();
  return gpu::Device::create({.validation = validation, .instance_extensions = extensions, .present = true});
#else
  (void)validation;
  throw Error("this build", "", "no window support", "a build with TYPODONT_WINDOW=ON");
#endif
}

}  // namespace

/// Scale of the interface: the screen's scale, but smaller if the panels
/// would not fit. In steps of 1/8, because each new scale builds fonts.
static double scale_of(const display::Output& output) {
  constexpr display::dvec2 kRoom(1100, 700);  // pixels, size that the panels need at scale 1
  const display::dvec2 fits = display::dvec2(output.size()) / kRoom;
  const double most = std::floor(8 * std::min(fits.x, fits.y)) / 8;
  return std::min(output.scale(), std::max(most, 1.0));
}

bool can_show(session::Language language) {
  return language != session::Language::kChinese || first_of(kChineseFonts);
}

void InterfaceWindow::open() {
  device_ = make_device(options_.validation);
  ring_ = gpu::FrameRing::create(device_);
#ifdef TYPODONT_WINDOW
  output_ = display::make_window(device_, {.title = options_.title,
                                           .size = options_.size,
                                           .fits_screen = true,
                                           .max_frames_per_second = 60,
                                           .urgent = options_.urgent});
#endif
  scale_ = scale_of(*output_);
  build_fonts();
  painter_ = std::make_unique<DrawListPainter>(device_);
}

void InterfaceWindow::close() {
  wait_idle();
  painter_.reset();
  output_.reset();
  ring_.destroy(device_);
  device_.destroy();
}

void InterfaceWindow::recreate_device() {
  options_.size = output_->size();
  close();
  open();
}

InterfaceWindow::InterfaceWindow(const Options& options) : options_(options) {
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
  io.BackendRendererName = io.BackendPlatformName = "typodont";
  const std::pair<int, int> map[] = {{ImGuiKey_Tab, keys::kTab},
                                     {ImGuiKey_LeftArrow, keys::kLeft},
                                     {ImGuiKey_RightArrow, keys::kRight},
                                     {ImGuiKey_UpArrow, keys::kUp},
                                     {ImGuiKey_DownArrow, keys::kDown},
                                     {ImGuiKey_PageUp, keys::kPageUp},
                                     {ImGuiKey_PageDown, keys::kPageDown},
                                     {ImGuiKey_Home, keys::kHome},
                                     {ImGuiKey_End, keys::kEnd},
                                     {ImGuiKey_Insert, keys::kInsert},
                                     {ImGuiKey_Delete, keys::kDelete},
                                     {ImGuiKey_Backspace, keys::kBackspace},
                                     {ImGuiKey_Space, ' '},
                                     {ImGuiKey_Enter, keys::kEnter},
                                     {ImGuiKey_Escape, keys::kEscape},
                                     {ImGuiKey_KeyPadEnter, keys::kKeypadEnter},
                                     {ImGuiKey_A, 'A'},
                                     {ImGuiKey_C, 'C'},
                                     {ImGuiKey_V, 'V'},
                                     {ImGuiKey_X, 'X'},
                                     {ImGuiKey_Y, 'Y'},
                                     {ImGuiKey_Z, 'Z'}};
  for (const auto& [imgui, ours] : map) io.KeyMap[imgui] = ours;
  try {
    open();
  } catch (...) {
    ImGui::DestroyContext();
    throw;
  }
}

InterfaceWindow::~InterfaceWindow() {
  close();
  ImGui::DestroyContext();
}

void InterfaceWindow::wait_idle() {
  if (device_.device) vkDeviceWaitIdle(device_.device);  // no device if creating a new one failed
}

void InterfaceWindow::build_fonts() {
  wait_idle();
  style_.unit = static_cast<float>(16 * scale_);
  set_theme(style_.unit);
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  atlas.Clear();
  // Characters that the fonts contain: Latin, Greek (µ), punctuation, arrows and mathematics; for Chinese, the
  // characters of the text catalogue.
  static constexpr ImWchar latin[] = {0x20,   0x17f,  0x370,  0x3ff,  0x2010, 0x205e, 0x2070,
                                      0x209f, 0x20ac, 0x20ac, 0x2190, 0x21ff, 0x2200, 0x22ff,
                                      0x25a0, 0x25ff, 0x2600, 0x26ff, 0x2713, 0x2717, 0};
  ImVector<ImWchar> chinese;
  const char* const font = first_of(kChineseFonts);
  if (language_ == session::Language::kChinese && font) {
    ImFontGlyphRangesBuilder builder;
    for (const std::string_view key : session::catalogue_keys()) {
      const std::string_view text = session::text(key, language_);
      builder.AddText(text.data(), text.data() + text.size());
    }
    builder.AddText(more_.data(), more_.data() + more_.size());
    builder.AddRanges(atlas.GetGlyphRangesChineseSimplifiedCommon());
    builder.BuildRanges(&chinese);
  }
  const auto add = [&](float pixels) {
    ImFontConfig config;
    config.OversampleH = 2;
    ImFont* made = nullptr;
    if (const char* const file = first_of(kLatinFonts)) {
      made = atlas.AddFontFromFileTTF(file, pixels, &config, latin);
    } else {
      config.SizePixels = pixels;
      made = atlas.AddFontDefault(&config);
    }
    if (!chinese.empty()) {
      ImFontConfig merge;
      merge.MergeMode = true;
      merge.OversampleH = 1;
      atlas.AddFontFromFileTTF(font, pixels * 1.08f, &merge, chinese.Data);
    }
    return made;
  };
  style_.plain = add(style_.unit);
  style_.large = add(style_.unit * 1.5f);
  style_.small = add(style_.unit * 0.84f);
  atlas.Build();
  if (painter_) painter_->take_font_atlas();
}

bool InterfaceWindow::set_language(session::Language language) {
  if (language == language_) return true;
  if (!can_show(language)) return false;
  language_ = language;
  build_fonts();
  return true;
}

void InterfaceWindow::announce_text(const std::string& text) {
  if (language_ != session::Language::kChinese) return;
  bool missing = false;
  for (const char* at = text.c_str(); *at;) {
    unsigned code = 0;
    at += ImTextCharFromUtf8(&code, at, nullptr);
    missing =
        missing || (code > 0x7f && code < 0xffff && !style_.plain->FindGlyphNoFallback(static_cast<ImWchar>(code)));
  }
  if (!missing) return;
  more_ += text;
  build_fonts();
}

bool InterfaceWindow::poll(double max_seconds) {
  const display::UserInput before = input_;
  input_ = output_->poll();
  const Nanos t = now();
  const bool used = input_.close || !input_.keys.empty() || input_.wheel != 0 || !input_.dropped.empty() ||
                    input_.pixel != before.pixel || input_.left != before.left || input_.right != before.right ||
                    input_.focused != before.focused;
  if (used) last_input_ = t;
  ImGuiIO& io = ImGui::GetIO();
  keys_.add(input_.keys);
  if (input_.focused != before.focused) io.AddFocusEvent(input_.focused);
  io.MousePos = {static_cast<float>(input_.pixel.x), static_cast<float>(input_.pixel.y)};
  io.MouseDown[0] = input_.left;
  io.MouseDown[1] = input_.right;
  io.MouseDown[2] = input_.middle;
  io.MouseWheel += static_cast<float>(input_.wheel);
  return used || !keys_.empty() || output_->needs_frame() || to_seconds(t - last_input_) < kSettle ||
         to_seconds(t - last_frame_) >= max_seconds;
}

void InterfaceWindow::begin(bool emergency_stop) {
  if (const double scale = scale_of(*output_); scale != scale_) {
    scale_ = scale;
    build_fonts();
  }
  ImGuiIO& io = ImGui::GetIO();
  const Nanos t = now();
  io.DeltaTime = std::clamp(static_cast<float>(to_seconds(t - last_frame_)), 1e-4f, 0.2f);
  last_frame_ = t;
  const display::ivec2 size = output_->size();
  io.DisplaySize = {static_cast<float>(std::max(size.x, 1)), static_cast<float>(std::max(size.y, 1))};
  // ImGui 1.86 reads keys once per frame and would miss a short press, so each key has at most one event per frame.
  for (const KeyQueue::Key& key : keys_.next(emergency_stop)) {
    if (key.typed)
      io.AddInputCharacter(key.typed);
    else
      io.KeysDown[key.code] = key.down;
  }
  io.KeyCtrl = io.KeysDown[keys::kLeftControl] || io.KeysDown[keys::kRightControl];
  io.KeyShift = io.KeysDown[keys::kLeftShift] || io.KeysDown[keys::kRightShift];
  io.KeyAlt = io.KeysDown[keys::kLeftAlt] || io.KeysDown[keys::kRightAlt];
  io.KeySuper = io.KeysDown[keys::kLeftSuper] || io.KeysDown[keys::kRightSuper];
  painter_->new_frame();
  ImGui::NewFrame();
}

void InterfaceWindow::end(bool shown) {
  ImGui::Render();
  if (!shown) return std::this_thread::sleep_for(kUnshownFrame);
  const VkCommandBuffer commands = ring_.begin(device_);
  const bool screen_lost_it = output_->needs_frame();
  const auto target = output_->acquire();
  if (!target) {
    ring_.abandon(device_);
    return;
  }
  const ImVec4 back = ImGui::GetStyle().Colors[ImGuiCol_WindowBg];
  const auto drawn = painter_->record(commands, *ImGui::GetDrawData(), *target, ring_.slot(),
                                      {back.x, back.y, back.z, 1}, screen_lost_it);
  ring_.submit(device_, target->ready, target->done);
  output_->present(drawn, [this, slot = ring_.slot()] { ring_.wait(device_, slot); });
  ++frames_;
}

void InterfaceWindow::set_title(const std::string& title) {
  if (title == options_.title) return;
  options_.title = title;
  output_->set_title(title);
}

void* InterfaceWindow::texture(const gpu::Image& picture, std::uint64_t shows) {
  // A new picture may get the handle of a destroyed one, so the content's number also contains the count of uploads.
  return painter_->texture(picture.alias_view ? picture.alias_view : picture.view, shows << 32 | uploads_);
}

gpu::Image InterfaceWindow::upload(const render::Picture& picture) {
  gpu::Image image = gpu::Image::create(
      device_, {.size = {static_cast<std::uint32_t>(picture.size.x), static_cast<std::uint32_t>(picture.size.y)},
                .format = VK_FORMAT_R8G8B8A8_UNORM,
                .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
  gpu::upload(device_, image, picture.rgba);
  ++uploads_;
  return image;
}

void InterfaceWindow::replace(std::vector<gpu::Image>& images, std::span<const render::Picture> pictures) {
  if (!images.empty()) wait_idle();
  for (gpu::Image& image : images) image.destroy(device_);
  images.clear();
  for (const render::Picture& picture : pictures) images.push_back(upload(picture));
}

}  // namespace typodont
