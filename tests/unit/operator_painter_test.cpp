// Tests that the operator's window is drawn again only where its content changes.
#include <gtest/gtest.h>
#include <imgui.h>

#include <random>

#include "engine/app/operator/draw_list_painter.h"

namespace typodont {
namespace {

using Parts = std::optional<std::vector<display::Part>>;

constexpr display::ivec2 kSize{400, 300};

/// An interface of Dear ImGui in memory. It is drawn twice: once only where it differs, and once completely.
struct Painter : testing::Test {
  void SetUp() override {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {static_cast<float>(kSize.x), static_cast<float>(kSize.y)};
    io.DeltaTime = 0.02f;
    io.Fonts->Build();
    device = gpu::Device::create({});
    ring = gpu::FrameRing::create(device);
    painter = std::make_unique<DrawListPainter>(device);
    differing = display::make_offscreen(device, kSize);
    whole = display::make_offscreen(device, kSize);
    picture = gpu::Image::create(device, {.size = {8, 8},
                                          .format = VK_FORMAT_R8G8B8A8_UNORM,
                                          .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    fill_picture(100);
  }
  void TearDown() override {
    vkDeviceWaitIdle(device.device);
    picture.destroy(device);
    differing.reset();
    whole.reset();
    painter.reset();
    ring.destroy(device);
    device.destroy();
    ImGui::DestroyContext();
  }
  void fill_picture(std::uint8_t value) {
    vkDeviceWaitIdle(device.device);
    gpu::upload(device, picture, std::vector<std::uint8_t>(8 * 8 * 4, value));
    ++shows;
  }

  Parts draw_into(display::Output& output, bool all) {
    const VkCommandBuffer commands = ring.begin(device);
    const display::Target target = output.acquire().value();
    const Parts parts =
        painter->record(commands, *ImGui::GetDrawData(), target, ring.slot(), {0.1f, 0.2f, 0.3f, 1}, all);
    ring.submit(device, target.ready, target.done);
    return parts;
  }
  /// Returns a frame with some text, a bar, a panel that moves, and a picture.
  Parts frame(const std::string& clock, float bar, ImVec2 panel, bool with_picture) {
    painter->new_frame();
    ImGui::NewFrame();
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({250, 200});
    ImGui::Begin("page", nullptr, ImGuiWindowFlags_NoDecoration);
    ImGui::TextUnformatted(clock.c_str());
    ImGui::ProgressBar(bar, {180, 12}, "");
    ImGui::Button("a button");
    if (with_picture) ImGui::Image(painter->texture(picture.view, shows), {90, 70});
    ImGui::End();
    ImGui::SetNextWindowPos(panel);
    ImGui::SetNextWindowSize({120, 60});
    ImGui::Begin("panel", nullptr, ImGuiWindowFlags_NoDecoration);
    ImGui::TextUnformatted("moves");
    ImGui::End();
    ImGui::Render();
    const Parts parts = draw_into(*differing, false);
    EXPECT_FALSE(draw_into(*whole, true).has_value()) << "all of it was wanted";
    ring.wait_idle(device);
    return parts;
  }
  static int area(const Parts& parts) {
    int pixels = 0;
    for (const display::Part& p : parts.value()) pixels += p.width * p.height;
    return pixels;
  }

  gpu::Device device;
  gpu::FrameRing ring;
  std::unique_ptr<DrawListPainter> painter;
  std::unique_ptr<display::Output> differing, whole;
  gpu::Image picture;
  std::uint64_t shows = 0;
};

TEST_F(Painter, ARunningClockRedrawsItsOwnTilesAndAnEqualFrameRedrawsNothing) {
  EXPECT_FALSE(frame("0:31", 0.5f, {260, 220}, true).has_value()) << "there was none before";
  frame("0:31", 0.5f, {260, 220}, true);  // a window appears in its first frames
  EXPECT_EQ(area(frame("0:31", 0.5f, {260, 220}, true)), 0);
  const Parts next = frame("0:32", 0.5f, {260, 220}, true);
  EXPECT_GT(area(next), 0);
  EXPECT_LT(area(next), kSize.x * kSize.y / 20);
  EXPECT_EQ(differing->read(), whole->read());
}

TEST_F(Painter, AnySequenceOfFramesLooksLikeCompletelyDrawnFrames) {
  std::mt19937 random(7);
  const auto chance = [&](int of) { return random() % static_cast<unsigned>(of) == 0; };
  std::string clock = "0:00";
  float bar = 0;
  ImVec2 panel{260, 220};
  bool with_picture = true;
  for (int i = 0; i < 60; ++i) {
    if (chance(2)) clock = std::to_string(random() % 100000);
    if (chance(3)) bar = static_cast<float>(random() % 101) / 100;
    if (chance(3)) panel = {static_cast<float>(random() % 380), static_cast<float>(random() % 280)};
    if (chance(5)) with_picture = !with_picture;
    if (chance(4)) fill_picture(static_cast<std::uint8_t>(random() % 256));
    frame(clock, bar, panel, with_picture);
    ASSERT_EQ(differing->read(), whole->read()) << "frame " << i;
  }
}

}  // namespace
}  // namespace typodont
