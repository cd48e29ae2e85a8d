// Headset through OpenXR, without assumptions beyond the specification: any formats and numbers of images; extensions
// may be missing, and poses invalid.
#include "engine/display/hmd.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <thread>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/units.h"
#include "engine/display/xr/api.h"
#include "engine/display/xr/eye_pictures.h"
#include "engine/display/xr/input.h"
#include "engine/display/xr/placement.h"

namespace typodont::display {

namespace {

using namespace xr;
using namespace std::chrono_literals;

constexpr double kNear = 0.02, kFar = 30;  // m, near and far clip plane
constexpr XrViewConfigurationType kStereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
constexpr XrSpaceLocationFlags kLocated =
    XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
constexpr XrViewStateFlags kViewsValid = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;

/// A displayed head pose, for comparison with the measured one.
struct Shown {
  XrTime time = 0;
  HmdTiming timing;
  Pose X_DV;
  bool located = false;
};

class OpenXrHmd final : public Hmd {
 public:
  OpenXrHmd(const DisplayRig& rig, RuntimeGate& gate) : rig_(rig.hmd), api(gate) {
    find_headset();
    XrGraphicsRequirementsVulkanKHR requirements{XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR};
    api.call("xrGetVulkanGraphicsRequirements2KHR", api.GetVulkanGraphicsRequirements2KHR, api.instance(), system_,
             &requirements);
  }
  ~OpenXrHmd() override { end(); }

  gpu::DeviceOptions device_options() override {
    gpu::DeviceOptions options;
    options.create_instance = [this](const VkInstanceCreateInfo& info, VkInstance& instance) {
      const XrVulkanInstanceCreateInfoKHR create{
          XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR, nullptr, system_, 0, vkGetInstanceProcAddr, &info, nullptr};
      VkResult result = VK_ERROR_INITIALIZATION_FAILED;
      api.call("xrCreateVulkanInstanceKHR", api.CreateVulkanInstanceKHR, api.instance(), &create, &instance, &result);
      return result;
    };
    options.choose_physical = [this](VkInstance instance) {
      const XrVulkanGraphicsDeviceGetInfoKHR get{XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR, nullptr, system_,
                                                 instance};
      VkPhysicalDevice physical = VK_NULL_HANDLE;
      api.call("xrGetVulkanGraphicsDevice2KHR", api.GetVulkanGraphicsDevice2KHR, api.instance(), &get, &physical);
      return physical;
    };
    options.create_device = [this](VkPhysicalDevice physical, const VkDeviceCreateInfo& info, VkDevice& device) {
      const XrVulkanDeviceCreateInfoKHR create{
          XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR, nullptr, system_, 0, vkGetInstanceProcAddr, physical, &info, nullptr};
      VkResult result = VK_ERROR_INITIALIZATION_FAILED;
      api.call("xrCreateVulkanDeviceKHR", api.CreateVulkanDeviceKHR, api.instance(), &create, &device, &result);
      return result;
    };
    return options;
  }

  void begin(gpu::Device& device, const dvec3& work_W) override {
    placement_.emplace(rig_, work_W);
    const XrGraphicsBindingVulkanKHR binding{XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR,
                                             nullptr,
                                             device.instance,
                                             device.physical,
                                             device.device,
                                             device.queue_family,
                                             0};
    const XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, &binding, 0, system_};
    api.call("xrCreateSession", api.CreateSession, api.instance(), &info, &session_);
    create_spaces();
    pictures_.emplace(api, session_, name_, size_, rig_.depth);
    choose_blend();
    choose_refresh_rate();
    input_ = std::make_unique<Input>(api, session_);
    explain(fmt::format("headset depth: {}", wants_depth() ? "handed over"
                                             : !rig_.depth ? "off in the rig"
                                                           : "not taken by the runtime"));
    explain(fmt::format("headset hidden area: {}",
                        api.has(XR_KHR_VISIBILITY_MASK_EXTENSION_NAME) ? "left out" : "not told by the runtime"));
  }

  void wake() override {
    const Nanos until = now() + from_seconds(rig_.wait);
    while (!running_) {
      if (!poll()) throw Error("OpenXR", name_, "the session was ended before it began", "a headset that is worn");
      if (running_) return;
      if (now() > until)
        throw Error("OpenXR", name_, fmt::format("asleep for {:g} s", rig_.wait),
                    "a headset that is switched on and worn");
      std::this_thread::sleep_for(10ms);
    }
  }

  void end() override {
    input_.reset();
    pictures_.reset();
    if (passthrough_layer_)
      api.attempt("xrDestroyPassthroughLayerFB", api.DestroyPassthroughLayerFB, passthrough_layer_);
    if (passthrough_) api.attempt("xrDestroyPassthroughFB", api.DestroyPassthroughFB, passthrough_);
    for (XrSpace* space : {&view_space_, &space_}) {
      if (*space) api.attempt("xrDestroySpace", api.DestroySpace, *space);
      *space = XR_NULL_HANDLE;
    }
    passthrough_layer_ = XR_NULL_HANDLE;
    passthrough_ = XR_NULL_HANDLE;
    if (session_) api.attempt("xrDestroySession", api.DestroySession, session_);
    session_ = XR_NULL_HANDLE;
    running_ = false;
  }

  bool poll() override {
    for (;;) {
      XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER};
      if (api.call("xrPollEvent", api.PollEvent, api.instance(), &event) != XR_SUCCESS) break;
      handle(event);
    }
    return !over_;
  }
  bool running() const override { return running_; }

  HmdFrame wait() override {
    XrFrameState state{XR_TYPE_FRAME_STATE};
    const XrFrameWaitInfo wait_info{XR_TYPE_FRAME_WAIT_INFO};
    api.call("xrWaitFrame", api.WaitFrame, session_, &wait_info, &state);
    const XrFrameBeginInfo begin_info{XR_TYPE_FRAME_BEGIN_INFO};
    api.call("xrBeginFrame", api.BeginFrame, session_, &begin_info);

    HmdFrame frame;
    display_time_ = state.predictedDisplayTime;
    frame.period = to_seconds(state.predictedDisplayPeriod);
    frame.shown_at = program_time(display_time_);
    shown_ = {};
    shown_.time = display_time_;
    shown_.timing.t = now();
    if (last_display_time_ && state.predictedDisplayPeriod > 0) {
      const double periods =
          static_cast<double>(display_time_ - last_display_time_) / static_cast<double>(state.predictedDisplayPeriod);
      shown_.timing.missed = std::max(0, static_cast<int>(std::lround(std::min(periods, 1e6))) - 1);
    }
    last_display_time_ = display_time_;
    placement_->follow(display_time_);

    XrSpaceLocation head{XR_TYPE_SPACE_LOCATION};
    api.call("xrLocateSpace", api.LocateSpace, view_space_, space_, display_time_, &head);
    shown_.located = (head.locationFlags & kLocated) == kLocated;
    const Input::State hands = input_->read(space_, display_time_);
    frame.focused = hands.focused;
    if (hands.recentre) placement_->recentre();
    if (shown_.located) {
      shown_.X_DV = pose_of(head.pose);
      placement_->see(shown_.X_DV);
      frame.X_WH = shown_.timing.X_WH = placement_->in_workbench(shown_.X_DV);
    }
    const bool placed = placement_->known();
    frame.draw = state.shouldRender && locate_eyes(frame) && placed;
    for (std::size_t i = 0; i < 2 && placed; ++i) {
      const Input::Hand& hand = hands.hands[i];
      frame.hands[i] = {hand.tracked, {}, {}, hand.pedal, hand.change_tool, hand.mirror};
      if (!hand.tracked) continue;
      frame.hands[i].X_DT = hand.X_DA * Pose{rig_.tip, {1, 0, 0, 0}};
      frame.hands[i].X_WT = placement_->in_workbench(frame.hands[i].X_DT);
    }
    judge(state.predictedDisplayPeriod);
    return frame;
  }

  void record(VkCommandBuffer commands, const gpu::Image& pictures, const std::array<Depth, 2>& depth) override {
    pictures_->record(commands, pictures, depth);
  }

  void submit(const HmdFrame& frame) override {
    pictures_->release();
    std::array<XrCompositionLayerDepthInfoKHR, 2> depths{};
    std::array<XrCompositionLayerProjectionView, 2> views{};
    XrCompositionLayerProjection projection{XR_TYPE_COMPOSITION_LAYER_PROJECTION};
    XrCompositionLayerPassthroughFB through{XR_TYPE_COMPOSITION_LAYER_PASSTHROUGH_FB};
    std::vector<const XrCompositionLayerBaseHeader*> layers;
    if (frame.draw) {
      for (std::uint32_t eye = 0; eye < 2; ++eye) {
        views[eye] = {XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, nullptr, views_[eye].pose, views_[eye].fov,
                      pictures_->color(eye)};
        if (!pictures_->has_depth()) continue;
        depths[eye] = {XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR,
                       nullptr,
                       pictures_->depth(eye),
                       0,
                       1,
                       static_cast<float>(kNear),
                       static_cast<float>(kFar)};
        views[eye].next = &depths[eye];
      }
      projection.layerFlags = see_through() ? XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT : 0;
      projection.space = space_;
      projection.viewCount = 2;
      projection.views = views.data();
      if (passthrough_layer_) {
        through.flags = XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT;
        through.layerHandle = passthrough_layer_;
        layers.push_back(reinterpret_cast<const XrCompositionLayerBaseHeader*>(&through));
      }
      layers.push_back(reinterpret_cast<const XrCompositionLayerBaseHeader*>(&projection));
    }
    const XrFrameEndInfo info{
        XR_TYPE_FRAME_END_INFO, nullptr, display_time_, blend_, static_cast<std::uint32_t>(layers.size()),
        layers.data()};
    api.call("xrEndFrame", api.EndFrame, session_, &info);
    const Nanos done = now();
    shown_.timing.drawn = frame.draw;
    shown_.timing.pose_to_submit = to_seconds(done - shown_.timing.t);
    if (frame.shown_at) shown_.timing.margin = to_seconds(frame.shown_at - done);
    pending_.push_back(shown_);
  }

  void vibrate(int hand, const Vibration& vibration) override {
    // The duration is slightly longer than a frame, so the vibration ends by itself if it is not renewed.
    input_->vibrate(hand, vibration, 50'000'000);
  }

  void request_exit() override {
    if (running_)
      api.call("xrRequestExitSession", api.RequestExitSession, session_);
    else
      over_ = true;
    asked_to_exit_ = true;
  }

  ivec2 eye_pixels() const override { return size_; }
  bool wants_depth() const override { return pictures_ && pictures_->wants_depth(); }
  bool see_through() const override { return blend_ != XR_ENVIRONMENT_BLEND_MODE_OPAQUE || passthrough_layer_; }
  std::optional<std::vector<glm::vec3>> hidden() override { return std::exchange(fresh_hidden_, std::nullopt); }
  std::vector<HmdTiming> timings() override { return std::exchange(timings_, {}); }
  std::vector<std::string> explanations() const override { return explanations_; }

 private:
  void explain(std::string text) { explanations_.push_back(std::move(text)); }

  void find_headset() {
    const XrSystemGetInfo get{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    const XrResult found = api.attempt("xrGetSystem", api.GetSystem, api.instance(), &get, &system_);
    if (XR_FAILED(found))
      throw Error("OpenXR", api.runtime(), fmt::format("no headset ({})", xr::name_of(found)),
                  "a headset that is connected and switched on");
    XrSystemProperties properties{XR_TYPE_SYSTEM_PROPERTIES};
    api.call("xrGetSystemProperties", api.GetSystemProperties, api.instance(), system_, &properties);
    name_ = properties.systemName;
    const auto configurations = api.list<XrViewConfigurationType>(
        "xrEnumerateViewConfigurations", api.EnumerateViewConfigurations, {}, api.instance(), system_);
    if (std::find(configurations.begin(), configurations.end(), kStereo) == configurations.end())
      throw Error("OpenXR", name_, "no stereo view", "a headset with two eyes");
    const auto views =
        api.list<XrViewConfigurationView>("xrEnumerateViewConfigurationViews", api.EnumerateViewConfigurationViews,
                                          {XR_TYPE_VIEW_CONFIGURATION_VIEW}, api.instance(), system_, kStereo);
    if (views.size() != 2) throw Error("OpenXR", name_, fmt::format("{} views", views.size()), "2");
    for (const XrViewConfigurationView& v : views) {
      // Recommended size × `resolution`, within limits of headset and runtime.
      const auto fit = [&](std::uint32_t recommended, std::uint32_t most, std::uint32_t system_max) {
        const auto wanted = static_cast<std::uint32_t>(std::lround(recommended * rig_.resolution));
        const std::uint32_t limit = std::min(most ? most : wanted, system_max ? system_max : wanted);
        return static_cast<int>(std::clamp<std::uint32_t>(wanted, 1, std::max(1u, limit)));
      };
      const XrSystemGraphicsProperties& g = properties.graphicsProperties;
      size_ =
          glm::max(size_, ivec2(fit(v.recommendedImageRectWidth, v.maxImageRectWidth, g.maxSwapchainImageWidth),
                                fit(v.recommendedImageRectHeight, v.maxImageRectHeight, g.maxSwapchainImageHeight)));
    }
    explain(fmt::format("headset: {} through {}, {}×{} per eye", name_, api.runtime(), size_.x, size_.y));
  }

  void create_spaces() {
    const auto offered =
        api.list<XrReferenceSpaceType>("xrEnumerateReferenceSpaces", api.EnumerateReferenceSpaces, {}, session_);
    const bool has_stage = std::find(offered.begin(), offered.end(), XR_REFERENCE_SPACE_TYPE_STAGE) != offered.end();
    if (rig_.X_WD && rig_.stage && !has_stage)
      throw Error("OpenXR", name_, "no STAGE space", "a room set up in the runtime: the rig was measured in it");
    space_type_ = rig_.stage && has_stage ? XR_REFERENCE_SPACE_TYPE_STAGE : XR_REFERENCE_SPACE_TYPE_LOCAL;
    explain(fmt::format("headset space: {}{}", space_type_ == XR_REFERENCE_SPACE_TYPE_STAGE ? "STAGE" : "LOCAL",
                        rig_.X_WD ? ", measured" : ", the work is put before the user"));
    const auto create = [&](XrReferenceSpaceType type, XrSpace& space) {
      const XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, type, identity()};
      api.call("xrCreateReferenceSpace", api.CreateReferenceSpace, session_, &info, &space);
    };
    create(space_type_, space_);
    create(XR_REFERENCE_SPACE_TYPE_VIEW, view_space_);
  }

  void choose_blend() {
    const auto modes = api.list<XrEnvironmentBlendMode>(
        "xrEnumerateEnvironmentBlendModes", api.EnumerateEnvironmentBlendModes, {}, api.instance(), system_, kStereo);
    if (modes.empty()) throw Error("OpenXR", name_, "no blend mode", "at least one");
    const auto offers = [&](XrEnvironmentBlendMode mode) {
      return std::find(modes.begin(), modes.end(), mode) != modes.end();
    };
    blend_ = offers(XR_ENVIRONMENT_BLEND_MODE_OPAQUE) ? XR_ENVIRONMENT_BLEND_MODE_OPAQUE : modes.front();
    std::string how = "off";
    if (rig_.passthrough) {
      how = "not offered by this headset";
      if (offers(XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND)) {
        blend_ = XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND;
        how = "blended behind the work";
      } else if (offers(XR_ENVIRONMENT_BLEND_MODE_ADDITIVE)) {
        blend_ = XR_ENVIRONMENT_BLEND_MODE_ADDITIVE;
        how = "through the glass";
      } else if (api.CreatePassthroughFB && api.CreatePassthroughLayerFB) {
        const XrPassthroughCreateInfoFB info{XR_TYPE_PASSTHROUGH_CREATE_INFO_FB, nullptr,
                                             XR_PASSTHROUGH_IS_RUNNING_AT_CREATION_BIT_FB};
        if (XR_SUCCEEDED(
                api.attempt("xrCreatePassthroughFB", api.CreatePassthroughFB, session_, &info, &passthrough_))) {
          const XrPassthroughLayerCreateInfoFB layer{XR_TYPE_PASSTHROUGH_LAYER_CREATE_INFO_FB, nullptr, passthrough_,
                                                     XR_PASSTHROUGH_IS_RUNNING_AT_CREATION_BIT_FB,
                                                     XR_PASSTHROUGH_LAYER_PURPOSE_RECONSTRUCTION_FB};
          api.call("xrCreatePassthroughLayerFB", api.CreatePassthroughLayerFB, session_, &layer, &passthrough_layer_);
          how = "a camera layer behind the work";
        }
      }
    } else if (blend_ != XR_ENVIRONMENT_BLEND_MODE_OPAQUE) {
      how = "always: the headset has no opaque mode";
    }
    explain("headset passthrough: " + how);
  }

  void choose_refresh_rate() {
    if (rig_.refresh_hz <= 0) return;
    if (!api.EnumerateDisplayRefreshRatesFB || !api.RequestDisplayRefreshRateFB) {
      explain("headset refresh rate: the runtime's choice, it offers none to choose from");
      return;
    }
    const auto rates =
        api.list<float>("xrEnumerateDisplayRefreshRatesFB", api.EnumerateDisplayRefreshRatesFB, 0, session_);
    const auto off = [&](float rate) { return std::abs(rate - rig_.refresh_hz); };
    const auto best = std::min_element(rates.begin(), rates.end(), [&](float a, float b) { return off(a) < off(b); });
    if (best == rates.end()) return;
    api.call("xrRequestDisplayRefreshRateFB", api.RequestDisplayRefreshRateFB, session_, *best);
    explain(fmt::format("headset refresh rate: {:g} Hz asked for", *best));
  }

  void handle(const XrEventDataBuffer& event) {
    switch (event.type) {
      case XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED: {
        const auto& change = reinterpret_cast<const XrEventDataSessionStateChanged&>(event);
        if (change.session == session_) follow_state(change.state);
        break;
      }
      case XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING:
        throw RunFailure("headset: the runtime is going away (instance loss pending)");
      case XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING: {
        const auto& change = reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(event);
        if (change.session == session_ && change.referenceSpaceType == space_type_) {
          placement_->will_move(change.changeTime,
                                change.poseValid ? std::optional(pose_of(change.poseInPreviousSpace)) : std::nullopt);
        }
        break;
      }
      case XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR:
        mask_asked_ = false;
        break;
      case XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED: {
        const std::string profiles = input_->profiles();
        log::info("headset controllers: {}", profiles.empty() ? "none" : profiles);
        break;
      }
      case XR_TYPE_EVENT_DATA_EVENTS_LOST:
        log::warn("headset: {} events of the runtime were lost",
                  reinterpret_cast<const XrEventDataEventsLost&>(event).lostEventCount);
        break;
      case XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB:
        log::info("headset refresh rate: {:g} Hz",
                  reinterpret_cast<const XrEventDataDisplayRefreshRateChangedFB&>(event).toDisplayRefreshRate);
        break;
      default:
        break;  // the event belongs to an extension that is not used
    }
  }

  void follow_state(XrSessionState state) {
    switch (state) {
      case XR_SESSION_STATE_READY: {
        if (running_) break;
        const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr, kStereo};
        const XrResult result = api.attempt("xrBeginSession", api.BeginSession, session_, &info);
        // The session's state has changed meanwhile; the next event reports the change.
        if (result == XR_ERROR_SESSION_NOT_READY) break;
        if (XR_FAILED(result)) Api::fail("xrBeginSession", result);
        running_ = true;
        last_display_time_ = 0;
        pending_.clear();
        break;
      }
      case XR_SESSION_STATE_STOPPING: {
        if (!running_) break;
        running_ = false;
        const XrResult result = api.attempt("xrEndSession", api.EndSession, session_);
        if (XR_FAILED(result) && result != XR_ERROR_SESSION_NOT_STOPPING) Api::fail("xrEndSession", result);
        break;
      }
      case XR_SESSION_STATE_EXITING:
        over_ = true;
        break;
      case XR_SESSION_STATE_LOSS_PENDING:
        if (!asked_to_exit_) throw RunFailure("headset: the runtime is going away (session loss pending)");
        over_ = true;
        break;
      // Other results are reported by xrWaitFrame and xrSyncActions.
      default:
        break;
    }
  }

  /// Locates both eyes. Returns true if both positions are known.
  bool locate_eyes(HmdFrame& frame) {
    const XrViewLocateInfo info{XR_TYPE_VIEW_LOCATE_INFO, nullptr, kStereo, display_time_, space_};
    XrViewState state{XR_TYPE_VIEW_STATE};
    views_ = {XrView{XR_TYPE_VIEW}, XrView{XR_TYPE_VIEW}};
    std::uint32_t count = 0;
    api.call("xrLocateViews", api.LocateViews, session_, &info, &state, 2u, &count, views_.data());
    if (count != 2 || (state.viewStateFlags & kViewsValid) != kViewsValid) return false;
    bool new_frusta = !mask_asked_;
    for (std::size_t e = 0; e < 2; ++e) {
      const XrFovf& fov = views_[e].fov;
      const double angles[] = {fov.angleLeft, fov.angleRight, fov.angleDown, fov.angleUp};
      for (const double a : angles)
        if (!(std::abs(a) < 0.49 * kPi)) return false;
      if (!(fov.angleLeft < fov.angleRight && fov.angleDown < fov.angleUp)) return false;
      const double near = kNear / rig_.magnify, far = kFar / rig_.magnify;
      EyeView& eye = frame.eyes[e];
      const Pose X_WE = placement_->in_workbench(pose_of(views_[e].pose));
      eye.position = X_WE.p;
      const glm::dmat3 R_EW = glm::mat3_cast(glm::conjugate(X_WE.R));
      eye.view = dmat4(R_EW);
      eye.view[3] = glm::dvec4(-(R_EW * X_WE.p), 1);
      eye.frustum = {std::tan(angles[0]) * near,
                     std::tan(angles[1]) * near,
                     std::tan(angles[2]) * near,
                     std::tan(angles[3]) * near,
                     near,
                     far};
      eye.projection = vulkan_projection(eye.frustum);
      const std::array<float, 4> fovs{fov.angleLeft, fov.angleRight, fov.angleDown, fov.angleUp};
      if (fovs != mask_fov_[e]) new_frusta = true;
      mask_fov_[e] = fovs;
    }
    if (new_frusta && api.GetVisibilityMaskKHR) follow_mask(frame);
    mask_asked_ = true;
    return true;
  }

  void follow_mask(const HmdFrame& frame) {
    std::vector<glm::vec3> corners;
    for (std::uint32_t view = 0; view < 2; ++view) {
      XrVisibilityMaskKHR mask{XR_TYPE_VISIBILITY_MASK_KHR};
      const auto ask = [&] {
        return XR_SUCCEEDED(api.attempt("xrGetVisibilityMaskKHR", api.GetVisibilityMaskKHR, session_, kStereo, view,
                                        XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR, &mask));
      };
      if (!ask()) continue;
      std::vector<XrVector2f> vertices(mask.vertexCountOutput);
      std::vector<std::uint32_t> indices(mask.indexCountOutput);
      mask.vertexCapacityInput = mask.vertexCountOutput;
      mask.indexCapacityInput = mask.indexCountOutput;
      mask.vertices = vertices.data();
      mask.indices = indices.data();
      if (indices.empty() || vertices.empty() || !ask()) continue;
      const dmat4& P = frame.eyes[view].projection;
      for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        const bool good = std::max({indices[i], indices[i + 1], indices[i + 2]}) < vertices.size();
        for (std::size_t k = 0; good && k < 3; ++k) {
          const XrVector2f& v = vertices[indices[i + k]];
          // Projects the corners of the hidden triangles, which are given in the plane z = −1 of the eye.
          const glm::dvec4 clip = P * glm::dvec4(v.x, v.y, -1, 1);
          corners.emplace_back(static_cast<float>(clip.x / clip.w), static_cast<float>(clip.y / clip.w),
                               static_cast<float>(view));
        }
      }
    }
    fresh_hidden_ = std::move(corners);
  }

  Nanos program_time(XrTime time) {
    if (!api.ConvertTimeToTimespecTimeKHR || time <= 0) return 0;
    timespec at{};
    if (XR_FAILED(
            api.attempt("xrConvertTimeToTimespecTimeKHR", api.ConvertTimeToTimespecTimeKHR, api.instance(), time, &at)))
      return 0;
    return Nanos{at.tv_sec} * kNanosPerSecond + at.tv_nsec;
  }

  /// Compares predicted head poses with measured ones, which runtimes keep for 50 ms.
  void judge(XrDuration period) {
    // A time that has certainly passed; it is used if the clock cannot be read.
    XrTime present = display_time_ - 2 * period;
    if (api.ConvertTimespecTimeToTimeKHR) {
      const Nanos t = now();
      const timespec at{static_cast<time_t>(t / kNanosPerSecond), static_cast<long>(t % kNanosPerSecond)};
      XrTime converted = 0;
      if (XR_SUCCEEDED(api.attempt("xrConvertTimespecTimeToTimeKHR", api.ConvertTimespecTimeToTimeKHR, api.instance(),
                                   &at, &converted)))
        present = converted;
    }
    while (!pending_.empty() && (pending_.front().time <= present || pending_.size() > 8)) {
      Shown& shown = pending_.front();
      XrSpaceLocation head{XR_TYPE_SPACE_LOCATION};
      if (shown.located &&
          XR_SUCCEEDED(api.attempt("xrLocateSpace", api.LocateSpace, view_space_, space_, shown.time, &head)) &&
          (head.locationFlags & kLocated) == kLocated) {
        const Pose X_DV = pose_of(head.pose);
        shown.timing.judged = true;
        shown.timing.position_error = glm::length(X_DV.p - shown.X_DV.p);
        shown.timing.angle_error = rotation_angle(X_DV.R, shown.X_DV.R);
      }
      timings_.push_back(shown.timing);
      pending_.pop_front();
    }
  }

  HmdRig rig_;
  Api api;
  XrSystemId system_ = XR_NULL_SYSTEM_ID;
  std::string name_;
  XrSession session_ = XR_NULL_HANDLE;
  XrReferenceSpaceType space_type_ = XR_REFERENCE_SPACE_TYPE_LOCAL;
  XrSpace space_ = XR_NULL_HANDLE, view_space_ = XR_NULL_HANDLE;
  std::optional<EyePictures> pictures_;
  XrPassthroughFB passthrough_ = XR_NULL_HANDLE;
  XrPassthroughLayerFB passthrough_layer_ = XR_NULL_HANDLE;
  XrEnvironmentBlendMode blend_ = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
  std::unique_ptr<Input> input_;
  ivec2 size_{1};

  bool running_ = false, over_ = false, asked_to_exit_ = false;
  XrTime display_time_ = 0, last_display_time_ = 0;
  std::array<XrView, 2> views_{};
  bool mask_asked_ = false;
  std::array<std::array<float, 4>, 2> mask_fov_{};
  std::optional<std::vector<glm::vec3>> fresh_hidden_;
  std::optional<Placement> placement_;
  Shown shown_;
  std::deque<Shown> pending_;
  std::vector<HmdTiming> timings_;
  std::vector<std::string> explanations_;
};

}  // namespace

std::unique_ptr<Hmd> Hmd::open(const DisplayRig& rig, RuntimeGate& gate) {
  return std::make_unique<OpenXrHmd>(rig, gate);
}

}  // namespace typodont::display
