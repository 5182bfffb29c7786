#include "engine/host/screen.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <epoxy/gl.h>
#include <imgui.h>

#include <algorithm>
#include <array>

#include "engine/platform/window.h"

namespace ff::host {
namespace {

constexpr ImGuiWindowFlags kBare = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBackground;
/// Of the picture's height.
constexpr float kButtonHeight = 0.06f, kTitleSize = 0.11f, kTextSize = 0.032f;

ImVec4 pale() {
    return {0.96f, 0.94f, 0.88f, 1.0f};
}

void set_style() {
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.FrameRounding = 4.0f;
    style.WindowBorderSize = 0.0f;
    style.Colors[ImGuiCol_Button] = {0.10f, 0.12f, 0.14f, 0.75f};
    style.Colors[ImGuiCol_ButtonHovered] = {0.75f, 0.45f, 0.12f, 0.9f};
    style.Colors[ImGuiCol_ButtonActive] = {0.9f, 0.55f, 0.15f, 1.0f};
    style.Colors[ImGuiCol_NavHighlight] = {1.0f, 0.76f, 0.3f, 1.0f};
    style.Colors[ImGuiCol_FrameBg] = {0.10f, 0.12f, 0.14f, 0.75f};
    style.Colors[ImGuiCol_SliderGrab] = {0.9f, 0.55f, 0.15f, 1.0f};
    style.Colors[ImGuiCol_CheckMark] = {1.0f, 0.76f, 0.3f, 1.0f};
}

/// Text in the middle of a line, with a shadow so that it can be read before any picture.
void draw_text(ImDrawList& list, ImVec2 middle, float height, ImU32 color, const char* text) {
    ImFont* const font = ImGui::GetFont();
    const ImVec2 size = font->CalcTextSizeA(height, FLT_MAX, 0.0f, text);
    const ImVec2 at(middle.x - 0.5f * size.x, middle.y - 0.5f * size.y);
    const float shadow = std::max(1.0f, 0.06f * height);
    const ImU32 dark = (color & IM_COL32_A_MASK) / 2 & IM_COL32_A_MASK;
    list.AddText(font, height, {at.x + shadow, at.y + shadow}, dark, text);
    list.AddText(font, height, at, color, text);
}

void draw_hud(std::span<const HudItem> hud, ImVec2 size) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const auto place = [&](Vec2 p) { return ImVec2(p.x * size.x, p.y * size.y); };
    for (const HudItem& item : hud) {
        const ImVec2 at = place(item.at), to = place(item.to);
        switch (item.kind) {
            case HudItem::Kind::text:
                draw_text(list, at, item.size * size.y, item.color, item.text.c_str());
                break;
            case HudItem::Kind::bar:
                list.AddRectFilled(at, {at.x + to.x, at.y + to.y}, IM_COL32(0, 0, 0, 120), 3.0f);
                list.AddRectFilled(at, {at.x + std::clamp(item.value, 0.0f, 1.0f) * to.x, at.y + to.y}, item.color,
                                   3.0f);
                break;
            case HudItem::Kind::line:
                list.AddLine(at, to, item.color, std::max(1.0f, item.size * size.y));
                break;
        }
    }
}

}  // namespace

struct Screen::Impl {
    ImGuiContext* context = nullptr;
    bool has_glfw = false, has_gl = false;
    Menu last_menu = Menu::none;
    int selected = 0;                              ///< entry of the menu, for keys and gamepad
    bool pad_held_before = false;                  ///< a button of the gamepad that menus know
    int waiting_action = -1, waiting_trigger = 0;  ///< of the settings menu: whose new key is asked for
    std::array<char, 256> comment{};               ///< of the marker menu, ends with 0

    ~Impl() {
        if (context == nullptr) return;
        ImGui::SetCurrentContext(context);
        if (has_gl) ImGui_ImplOpenGL3_Shutdown();
        if (has_glfw) ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext(context);
    }

    Choice draw_menu(Menu menu, const MenuText& text, const platform::InputState& input, PlayerSettings& settings);
    Choice draw_settings(const platform::InputState& input, PlayerSettings& settings);
    void draw_keys(const platform::InputState& input, PlayerSettings& settings);
    Choice draw_marker(const platform::InputState& input);
    /// Moves the selection by arrow keys and gamepad. @return whether the selected entry is chosen
    bool choose_by_keys(Menu menu, int entries, const platform::InputState& input);
};

Screen::Screen(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Screen::Screen(Screen&&) noexcept = default;
Screen& Screen::operator=(Screen&&) noexcept = default;
Screen::~Screen() = default;

Result<Screen> Screen::make(const platform::Window& window) {
    auto impl = std::make_unique<Impl>();
    IMGUI_CHECKVERSION();
    impl->context = ImGui::CreateContext();
    ImGui::SetCurrentContext(impl->context);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // leaves no file behind
    io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard | ImGuiConfigFlags_NavEnableGamepad;
    set_style();
    impl->has_glfw = ImGui_ImplGlfw_InitForOpenGL(window.handle(), true);
    if (!impl->has_glfw) return failure("the menus cannot listen to the window");
    impl->has_gl = ImGui_ImplOpenGL3_Init("#version 450 core");
    if (!impl->has_gl) return failure("the menus cannot be drawn with this OpenGL driver");
    return Screen(std::move(impl));
}

Choice Screen::draw(std::span<const HudItem> hud, Menu menu, const MenuText& text, const platform::InputState& input,
                    PlayerSettings& settings, std::span<const std::pair<std::string, std::string>> rows) {
    ImGui::SetCurrentContext(impl_->context);
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    draw_hud(hud, ImGui::GetIO().DisplaySize);
    const Choice choice = menu == Menu::none ? Choice::none : impl_->draw_menu(menu, text, input, settings);
    impl_->last_menu = menu;
    if (!rows.empty()) {
        ImGui::SetNextWindowPos({8, 8}, ImGuiCond_Once);
        ImGui::SetNextWindowBgAlpha(0.65f);
        if (ImGui::Begin("frame", nullptr,
                         ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs)) {
            for (const auto& [name, value] : rows) ImGui::Text("%-14s %s", name.c_str(), value.c_str());
        }
        ImGui::End();
    }
    ImGui::Render();
    // Frames are drawn with depth 0 to 1 into targets of their own; the menus want GL's defaults and the window.
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    return choice;
}

std::string_view Screen::comment() const {
    return impl_->comment.data();
}

bool Screen::Impl::choose_by_keys(Menu menu, int entries, const platform::InputState& input) {
    using platform::Key;
    const auto pad = [&](int button) { return ((input.gamepad.buttons >> button) & 1) != 0; };
    constexpr int kPadA = 0, kPadUp = 11, kPadDown = 13;
    const bool opened = menu != last_menu;
    const bool pad_held = pad(kPadA) || pad(kPadUp) || pad(kPadDown), pad_new = pad_held && !pad_held_before;
    pad_held_before = pad_held;
    if (opened) {
        // What opened the menu does not choose in it.
        selected = 0;
        return false;
    }
    if (input.pressed(Key::down) || (pad_new && pad(kPadDown))) selected = (selected + 1) % entries;
    if (input.pressed(Key::up) || (pad_new && pad(kPadUp))) selected = (selected + entries - 1) % entries;
    selected = std::min(selected, entries - 1);
    return input.pressed(Key::enter) || input.pressed(Key::space) || (pad_new && pad(kPadA));
}

Choice Screen::Impl::draw_menu(Menu menu, const MenuText& text, const platform::InputState& input,
                               PlayerSettings& settings) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    ImDrawList& behind = *ImGui::GetBackgroundDrawList();
    behind.AddRectFilled({0, 0}, size, IM_COL32(8, 12, 18, menu == Menu::title ? 90 : 150));
    if (menu == Menu::settings) return draw_settings(input, settings);
    if (menu == Menu::marker) return draw_marker(input);

    draw_text(behind, {0.5f * size.x, 0.2f * size.y}, kTitleSize * size.y, ImGui::GetColorU32(pale()),
              text.title.c_str());
    // Line by line, each in the middle.
    float y = 0.33f * size.y;
    for (std::size_t at = 0; at < text.text.size();) {
        const std::size_t end = std::min(text.text.find('\n', at), text.text.size());
        draw_text(behind, {0.5f * size.x, y}, kTextSize * size.y, ImGui::GetColorU32(pale()),
                  text.text.substr(at, end - at).c_str());
        y += 1.4f * kTextSize * size.y;
        at = end + 1;
    }
    if (!text.notice.empty())
        draw_text(behind, {0.5f * size.x, 0.95f * size.y}, kTextSize * size.y, IM_COL32(255, 195, 76, 255),
                  text.notice.c_str());

    struct Entry {
        const char* label;
        Choice choice;
        bool shown;
    };
    const bool title = menu == Menu::title, pause = menu == Menu::pause, end = menu == Menu::end;
    const std::array entries{Entry{"Go on", Choice::go_on, pause},
                             Entry{title ? "Begin" : "Begin anew", Choice::start, title || end},
                             Entry{"Save", Choice::save, pause},
                             Entry{"Load", Choice::load, text.can_load},
                             Entry{"Settings", Choice::settings, title || pause},
                             Entry{"Title screen", Choice::to_title, pause || end},
                             Entry{"Quit", Choice::quit, true}};
    Choice choice = Choice::none;
    const float width = 0.34f * size.x;
    ImGui::SetNextWindowPos({0.5f * (size.x - width), 0.47f * size.y});
    ImGui::SetNextWindowSize({width, 0.45f * size.y});
    ImGui::Begin("menu", nullptr, kBare | ImGuiWindowFlags_NoNav);
    ImGui::SetWindowFontScale(kTextSize * size.y / ImGui::GetFont()->FontSize);
    const int shown = int(std::count_if(entries.begin(), entries.end(), [](const Entry& e) { return e.shown; }));
    const bool activates = choose_by_keys(menu, shown, input);
    int number = 0;
    for (const Entry& entry : entries) {
        if (!entry.shown) continue;
        const bool is_selected = number++ == selected;
        ImGui::PushStyleColor(ImGuiCol_Button,
                              ImGui::GetStyleColorVec4(is_selected ? ImGuiCol_ButtonHovered : ImGuiCol_Button));
        if (ImGui::Button(entry.label, {-1.0f, kButtonHeight * size.y})) choice = entry.choice;
        ImGui::PopStyleColor();
        if (is_selected && activates) choice = entry.choice;
        if (ImGui::IsItemHovered() && ImGui::GetIO().MouseDelta.y != 0.0f) selected = number - 1;
    }
    ImGui::End();
    return choice;
}

Choice Screen::Impl::draw_settings(const platform::InputState& input, PlayerSettings& settings) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({0.1f * size.x, 0.06f * size.y});
    ImGui::SetNextWindowSize({0.8f * size.x, 0.88f * size.y});
    if (last_menu != Menu::settings) ImGui::SetNextWindowFocus();
    ImGui::Begin("settings", nullptr, kBare & ~ImGuiWindowFlags_NoScrollbar);
    ImGui::SetWindowFontScale(0.75f * kTextSize * size.y / ImGui::GetFont()->FontSize);
    ImGui::PushItemWidth(0.4f * size.x);
    const auto slider = [](const char* label, double& value, double low, double high, const char* format) {
        ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &low, &high, format);
    };
    double fov = settings.fov_deg == 0.0 ? 65.0 : settings.fov_deg;
    slider("field of view", fov, 30.0, 110.0, "%.0f degrees");
    if (fov != 65.0 || settings.fov_deg != 0.0) settings.fov_deg = fov;
    slider("time of a frame", settings.budget_ms, 0.0, 100.0,
           settings.budget_ms > 0.0 ? "%.1f ms, then drawn coarser" : "whatever it takes");
    if (settings.budget_ms == 0.0)
        slider("error", settings.error_px, 0.0, 4.0, settings.error_px > 0.0 ? "up to %.1f pixels" : "exact pictures");
    constexpr std::array kHeights{240, 360, 480, 720, 1080};
    for (const int height : kHeights) {
        const std::string label = std::to_string(height * 4 / 3) + " x " + std::to_string(height);
        if (ImGui::RadioButton(label.c_str(), settings.height == height)) {
            settings.height = height;
            settings.width = height * 4 / 3;
        }
        ImGui::SameLine();
    }
    ImGui::TextUnformatted("picture");
    slider("sound", settings.volume, 0.0, 1.0, settings.volume > 0.0 ? "%.2f" : "none");
    slider("mouse", settings.mouse_speed, 0.05, 4.0, "%.2f x");
    ImGui::Checkbox("turn pitch around", &settings.invert_pitch);
    ImGui::Checkbox("full screen (from the next start on)", &settings.fullscreen);
    draw_keys(input, settings);
    ImGui::PopItemWidth();
    const bool back = ImGui::Button("Back", {0.3f * size.x, kButtonHeight * size.y});
    ImGui::End();
    const bool escape = waiting_action < 0 && input.pressed(platform::Key::escape);
    return back || escape ? Choice::back : Choice::none;
}

Choice Screen::Impl::draw_marker(const platform::InputState& input) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    draw_text(*ImGui::GetBackgroundDrawList(), {0.5f * size.x, 0.4f * size.y}, kTextSize * size.y,
              ImGui::GetColorU32(pale()), "A comment for the recording; Enter keeps it, Escape drops it");
    ImGui::SetNextWindowPos({0.15f * size.x, 0.45f * size.y});
    ImGui::SetNextWindowSize({0.7f * size.x, 0.1f * size.y});
    ImGui::Begin("marker", nullptr, kBare | ImGuiWindowFlags_NoNav);
    ImGui::SetWindowFontScale(kTextSize * size.y / ImGui::GetFont()->FontSize);
    if (last_menu != Menu::marker) {
        comment.fill('\0');
        ImGui::SetKeyboardFocusHere();
    }
    ImGui::PushItemWidth(-1.0f);
    const bool entered =
        ImGui::InputText("##comment", comment.data(), comment.size(), ImGuiInputTextFlags_EnterReturnsTrue);
    ImGui::PopItemWidth();
    ImGui::End();
    if (input.pressed(platform::Key::escape)) return Choice::go_on;
    return entered ? Choice::mark : Choice::none;
}

void Screen::Impl::draw_keys(const platform::InputState& input, PlayerSettings& settings) {
    if (waiting_action >= 0) {
        const loop::Trigger pressed = loop::pressed_trigger(input);
        const bool gives_up = input.pressed(platform::Key::escape);
        if (pressed.device != loop::Trigger::Device::none && !gives_up)
            settings.actions[std::size_t(waiting_action)].triggers[waiting_trigger] = pressed;
        if (pressed.device != loop::Trigger::Device::none || gives_up) waiting_action = -1;
    }
    if (!ImGui::BeginTable("keys", 4, ImGuiTableFlags_RowBg)) return;
    for (std::size_t a = 0; a < settings.actions.size(); ++a) {
        loop::Action& action = settings.actions[a];
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(action.name.c_str());
        for (int t = 0; t < int(std::size(action.triggers)); ++t) {
            ImGui::TableNextColumn();
            const bool waits = waiting_action == int(a) && waiting_trigger == t;
            const std::string label = (waits ? std::string("press a key") : trigger_name(action.triggers[t])) + "##" +
                                      std::to_string(a) + "." + std::to_string(t);
            if (ImGui::Button(label.c_str(), {-1.0f, 0.0f})) {
                waiting_action = int(a);
                waiting_trigger = t;
            }
        }
    }
    ImGui::EndTable();
}

}  // namespace ff::host
