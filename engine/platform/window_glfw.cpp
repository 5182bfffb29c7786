// epoxy before GLFW: it brings the GL header that GLFW then leaves alone.
#include <epoxy/gl.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/core.h>

#include <array>

#include "engine/platform/window.h"

namespace ff::platform {
namespace {

/// GLFW_KEY_* of each Key, in the order of the enum.
constexpr auto kGlfwKeys = std::to_array<int>({
    GLFW_KEY_A,
    GLFW_KEY_B,
    GLFW_KEY_C,
    GLFW_KEY_D,
    GLFW_KEY_E,
    GLFW_KEY_F,
    GLFW_KEY_G,
    GLFW_KEY_H,
    GLFW_KEY_I,
    GLFW_KEY_J,
    GLFW_KEY_K,
    GLFW_KEY_L,
    GLFW_KEY_M,
    GLFW_KEY_N,
    GLFW_KEY_O,
    GLFW_KEY_P,
    GLFW_KEY_Q,
    GLFW_KEY_R,
    GLFW_KEY_S,
    GLFW_KEY_T,
    GLFW_KEY_U,
    GLFW_KEY_V,
    GLFW_KEY_W,
    GLFW_KEY_X,
    GLFW_KEY_Y,
    GLFW_KEY_Z,
    GLFW_KEY_0,
    GLFW_KEY_1,
    GLFW_KEY_2,
    GLFW_KEY_3,
    GLFW_KEY_4,
    GLFW_KEY_5,
    GLFW_KEY_6,
    GLFW_KEY_7,
    GLFW_KEY_8,
    GLFW_KEY_9,
    GLFW_KEY_SPACE,
    GLFW_KEY_ENTER,
    GLFW_KEY_ESCAPE,
    GLFW_KEY_TAB,
    GLFW_KEY_BACKSPACE,
    GLFW_KEY_PAGE_UP,
    GLFW_KEY_PAGE_DOWN,
    GLFW_KEY_UP,
    GLFW_KEY_DOWN,
    GLFW_KEY_LEFT,
    GLFW_KEY_RIGHT,
    GLFW_KEY_LEFT_SHIFT,
    GLFW_KEY_RIGHT_SHIFT,
    GLFW_KEY_LEFT_CONTROL,
    GLFW_KEY_RIGHT_CONTROL,
    GLFW_KEY_LEFT_ALT,
    GLFW_KEY_RIGHT_ALT,
    GLFW_KEY_F1,
    GLFW_KEY_F2,
    GLFW_KEY_F3,
    GLFW_KEY_F4,
    GLFW_KEY_F5,
    GLFW_KEY_F6,
    GLFW_KEY_F7,
    GLFW_KEY_F8,
    GLFW_KEY_F9,
    GLFW_KEY_F10,
    GLFW_KEY_F11,
    GLFW_KEY_F12,
});
static_assert(kGlfwKeys.size() == std::size_t(Key::count));

std::string glfw_words() {
    const char* words = nullptr;
    glfwGetError(&words);
    return words ? words : "GLFW gives no reason";
}

/// glfwInit and glfwTerminate are the process's; count the windows that need them.
int open_windows = 0;

}  // namespace

struct Window::Impl {
    GLFWwindow* window = nullptr;
    // Gathered by the callbacks between two polls.
    std::bitset<std::size_t(Key::count)> pressed;
    double scroll = 0;
    double last_x = 0, last_y = 0;
    bool last_known = false;
    bool captured = false;

    ~Impl() {
        if (window) glfwDestroyWindow(window);
        if (--open_windows == 0) glfwTerminate();
    }

    static Impl& of(GLFWwindow* window) { return *static_cast<Impl*>(glfwGetWindowUserPointer(window)); }

    static void on_key(GLFWwindow* window, int key, int, int action, int) {
        if (action != GLFW_PRESS) return;
        for (std::size_t i = 0; i < kGlfwKeys.size(); ++i)
            if (kGlfwKeys[i] == key) of(window).pressed.set(i);
    }
    static void on_scroll(GLFWwindow* window, double, double dy) { of(window).scroll += dy; }
};

Window::Window(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Window::Window(Window&&) noexcept = default;
Window& Window::operator=(Window&&) noexcept = default;
Window::~Window() = default;

Result<Window> Window::open(const WindowSettings& settings) {
    if (settings.width < 1 || settings.height < 1)
        return usage_error(fmt::format("window of {}x{} pixels; at least 1x1", settings.width, settings.height));
    if (open_windows == 0 && !glfwInit())
        return failure(fmt::format("no window: {}; start a display, or run headless", glfw_words()));
    ++open_windows;
    auto impl = std::make_unique<Impl>();  // from here on its destructor gives GLFW back

    glfwWindowHint(GLFW_CLIENT_API, GLFW_OPENGL_API);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);  // we draw into targets of our own and blit
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    GLFWmonitor* monitor = settings.fullscreen ? glfwGetPrimaryMonitor() : nullptr;
    int width = settings.width, height = settings.height;
    if (monitor) {
        if (const GLFWvidmode* mode = glfwGetVideoMode(monitor)) {
            width = mode->width;
            height = mode->height;
        }
    }
    impl->window = glfwCreateWindow(width, height, settings.title.c_str(), monitor, nullptr);
    if (!impl->window) return failure(fmt::format("no window with OpenGL 4.5 core: {}", glfw_words()));

    glfwSetWindowUserPointer(impl->window, impl.get());
    glfwSetKeyCallback(impl->window, Impl::on_key);
    glfwSetScrollCallback(impl->window, Impl::on_scroll);
    glfwMakeContextCurrent(impl->window);
    glfwSwapInterval(settings.vsync ? 1 : 0);
    return Window(std::move(impl));
}

bool Window::poll(InputState& input) {
    Impl& w = *impl_;
    glfwPollEvents();

    for (std::size_t i = 0; i < kGlfwKeys.size(); ++i) input.keys[i] = glfwGetKey(w.window, kGlfwKeys[i]) == GLFW_PRESS;
    input.keys_pressed = w.pressed;
    w.pressed.reset();
    constexpr int kButtons[] = {GLFW_MOUSE_BUTTON_LEFT, GLFW_MOUSE_BUTTON_RIGHT, GLFW_MOUSE_BUTTON_MIDDLE};
    for (std::size_t i = 0; i < std::size_t(MouseButton::count); ++i)
        input.mouse_buttons[i] = glfwGetMouseButton(w.window, kButtons[i]) == GLFW_PRESS;

    glfwGetCursorPos(w.window, &input.mouse_x, &input.mouse_y);
    // The first position after a capture is a jump, not a movement.
    const bool moves = w.captured && w.last_known;
    input.mouse_dx = moves ? input.mouse_x - w.last_x : 0.0;
    input.mouse_dy = moves ? input.mouse_y - w.last_y : 0.0;
    w.last_x = input.mouse_x;
    w.last_y = input.mouse_y;
    w.last_known = true;
    input.scroll = w.scroll;
    w.scroll = 0;

    input.gamepad = {};
    GLFWgamepadstate pad;
    for (int id = GLFW_JOYSTICK_1; id <= GLFW_JOYSTICK_LAST; ++id) {
        if (!glfwJoystickIsGamepad(id) || !glfwGetGamepadState(id, &pad)) continue;
        GamepadState& out = input.gamepad;
        out.connected = true;
        out.left_x = pad.axes[GLFW_GAMEPAD_AXIS_LEFT_X];
        out.left_y = pad.axes[GLFW_GAMEPAD_AXIS_LEFT_Y];
        out.right_x = pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_X];
        out.right_y = pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_Y];
        apply_dead_zone(out.left_x, out.left_y);
        apply_dead_zone(out.right_x, out.right_y);
        out.left_trigger = 0.5f * (pad.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER] + 1.0f);
        out.right_trigger = 0.5f * (pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] + 1.0f);
        for (int b = 0; b <= GLFW_GAMEPAD_BUTTON_LAST; ++b)
            if (pad.buttons[b] == GLFW_PRESS) out.buttons = std::uint16_t(out.buttons | (1u << b));
        break;  // the first one that is there
    }
    return !glfwWindowShouldClose(w.window);
}

void Window::swap() {
    glfwSwapBuffers(impl_->window);
}

FramebufferSize Window::framebuffer_size() const {
    FramebufferSize size;
    glfwGetFramebufferSize(impl_->window, &size.width, &size.height);
    return size;
}

void Window::set_title(const std::string& title) {
    glfwSetWindowTitle(impl_->window, title.c_str());
}

void Window::capture_mouse(bool captured) {
    if (captured == impl_->captured) return;
    impl_->captured = captured;
    impl_->last_known = false;
    glfwSetInputMode(impl_->window, GLFW_CURSOR, captured ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
    if (glfwRawMouseMotionSupported()) glfwSetInputMode(impl_->window, GLFW_RAW_MOUSE_MOTION, captured ? 1 : 0);
}

bool Window::mouse_captured() const {
    return impl_->captured;
}

GLFWwindow* Window::handle() const {
    return impl_->window;
}

}  // namespace ff::platform
