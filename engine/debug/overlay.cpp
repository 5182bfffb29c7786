#include "engine/debug/overlay.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <epoxy/gl.h>
#include <imgui.h>

#include <algorithm>

#include "engine/platform/window.h"

namespace ff::debug {

struct Overlay::Impl {
    ImGuiContext* context = nullptr;
    bool has_glfw = false, has_gl = false;

    ~Impl() {
        if (!context) return;
        ImGui::SetCurrentContext(context);
        if (has_gl) ImGui_ImplOpenGL3_Shutdown();
        if (has_glfw) ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext(context);
    }
};

Overlay::Overlay(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Overlay::Overlay(Overlay&&) noexcept = default;
Overlay& Overlay::operator=(Overlay&&) noexcept = default;
Overlay::~Overlay() = default;

Result<Overlay> Overlay::make(const platform::Window& window) {
    auto impl = std::make_unique<Impl>();
    IMGUI_CHECKVERSION();
    impl->context = ImGui::CreateContext();
    ImGui::SetCurrentContext(impl->context);
    ImGui::GetIO().IniFilename = nullptr;  // leaves no file behind
    ImGui::StyleColorsDark();
    // It keeps the window's own callbacks and calls them too.
    impl->has_glfw = ImGui_ImplGlfw_InitForOpenGL(window.handle(), true);
    if (!impl->has_glfw) return failure("the overlay cannot listen to the window");
    impl->has_gl = ImGui_ImplOpenGL3_Init("#version 450 core");
    if (!impl->has_gl) return failure("the overlay cannot draw with this OpenGL driver");
    return Overlay(std::move(impl));
}

void Overlay::draw(const OverlayData& data) {
    ImGui::SetCurrentContext(impl_->context);
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    ImGui::SetNextWindowPos(ImVec2(8, 8), ImGuiCond_Once);
    ImGui::SetNextWindowBgAlpha(0.65f);
    constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing |
                                        ImGuiWindowFlags_NoNavInputs | ImGuiWindowFlags_NoNavFocus;
    // Titles change (they hold numbers); the part after ### is the window's identity.
    if (ImGui::Begin((data.title + "###overlay").c_str(), nullptr, kFlags)) {
        if (!data.graph.empty()) {
            const float top = data.graph_budget_ms > 0.0f
                                  ? 2.0f * data.graph_budget_ms
                                  : 1.1f * *std::max_element(data.graph.begin(), data.graph.end());
            ImGui::PlotLines("##graph", data.graph.data(), int(data.graph.size()), 0, nullptr, 0.0f, top,
                             ImVec2(280, 60));
        }
        if (ImGui::BeginTable("rows", 2, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_RowBg)) {
            for (const OverlayData::Row& row : data.rows) {
                ImGui::TableNextRow();
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(row.name.c_str());
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(row.value.c_str());
            }
            ImGui::EndTable();
        }
    }
    ImGui::End();
    ImGui::Render();
    // The scene is drawn with depth 0 to 1 and our own target; the overlay wants GL's defaults and the window.
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

bool Overlay::wants_mouse() const {
    ImGui::SetCurrentContext(impl_->context);
    return ImGui::GetIO().WantCaptureMouse;
}

bool Overlay::wants_keyboard() const {
    ImGui::SetCurrentContext(impl_->context);
    return ImGui::GetIO().WantCaptureKeyboard;
}

}  // namespace ff::debug
