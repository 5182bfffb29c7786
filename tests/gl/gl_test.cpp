#include <gtest/gtest.h>

#include <cstring>
#include <numeric>
#include <vector>

#include "engine/gl/buffer.h"
#include "engine/gl/program.h"
#include "engine/gl/shader_sources.h"
#include "engine/gl/target.h"
#include "engine/gl/timer.h"
#include "tests/gl/gl_fixture.h"

namespace ff::gl {
namespace {

using BufferTest = test::GlTest;
using TargetTest = test::GlTest;
using TimerTest = test::GlTest;

/// Compiler errors reach the debug output too, so no fixture that forbids them.
class ProgramTest : public test::GlTest {
  protected:
    void TearDown() override { enable_debug_output(); }
};

std::vector<std::byte> read_back(GLuint buffer, std::uint64_t offset, std::size_t size) {
    std::vector<std::byte> bytes(size);
    glGetNamedBufferSubData(buffer, GLintptr(offset), GLsizeiptr(size), bytes.data());
    return bytes;
}

TEST_F(BufferTest, holds_what_was_written_even_in_many_pieces) {
    std::vector<std::byte> bytes((33u << 20) + 5);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = std::byte(i * 2654435761u >> 24);
    auto buffer = Buffer::make(bytes.size() + 3);
    ASSERT_TRUE(buffer) << buffer.error().message;
    buffer->write(3, bytes);
    EXPECT_EQ(read_back(buffer->id(), 3, bytes.size()), bytes);
}

TEST_F(BufferTest, of_nothing_is_allowed) {
    EXPECT_TRUE(Buffer::make(0));
}

TEST_F(BufferTest, streams_keep_a_frames_data_while_the_next_are_written) {
    StreamBuffer stream;
    std::vector<std::uint64_t> offsets;
    GLuint id = 0;
    for (unsigned frame = 0; frame < 7; ++frame) {
        const std::span<std::byte> segment = stream.begin(1000);
        ASSERT_GE(segment.size(), 1000u);
        std::memset(segment.data(), int(frame), 1000);
        if (frame == 0) id = stream.id();
        EXPECT_EQ(stream.id(), id);
        EXPECT_EQ(stream.offset() % 256, 0u);
        offsets.push_back(stream.offset());
        EXPECT_EQ(read_back(stream.id(), stream.offset(), 1000), std::vector<std::byte>(1000, std::byte(frame)));
        if (frame > 0) {
            EXPECT_EQ(read_back(stream.id(), offsets[frame - 1], 1000),
                      std::vector<std::byte>(1000, std::byte(frame - 1)));
        }
        stream.end();
    }
    EXPECT_GE(stream.begin(1u << 20).size(), 1u << 20);  // grows
    stream.end();
}

TEST_F(TargetTest, can_be_cleared_and_read_back) {
    auto target = Target::make(GL_RG32UI, 20, 10);
    ASSERT_TRUE(target) << target.error().message;
    const GLuint value[4] = {7, 0xFFFFFFFEu, 0, 0};
    glClearNamedFramebufferuiv(target->id(), GL_COLOR, 0, value);
    std::vector<std::uint32_t> pixels(2 * 20 * 10);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target->id());
    glReadPixels(0, 0, 20, 10, GL_RG_INTEGER, GL_UNSIGNED_INT, pixels.data());
    for (std::size_t i = 0; i < pixels.size(); ++i) EXPECT_EQ(pixels[i], value[i % 2]);
}

TEST_F(TargetTest, of_a_size_that_the_driver_refuses_is_an_error) {
    const auto target = Target::make(GL_RGBA8, 1 << 20, 4);
    ASSERT_FALSE(target);
    EXPECT_NE(target.error().message.find("1048576x4"), std::string::npos) << target.error().message;
}

TEST_F(TimerTest, gives_each_measured_time_once) {
    Timer timer = Timer::make();
    EXPECT_FALSE(timer.poll_ms());
    for (int i = 0; i < 10; ++i) {  // more than are kept
        timer.begin();
        timer.end();
    }
    glFinish();
    const auto ms = timer.poll_ms();
    ASSERT_TRUE(ms);
    EXPECT_GE(*ms, 0.0);
    EXPECT_FALSE(timer.poll_ms());
}

TEST_F(ProgramTest, a_compile_error_shows_the_line_that_it_means) {
    const auto program =
        Program::compile({"broken.vert", "#version 450 core\nvoid main() {\n    gl_Position = fish;\n}\n"},
                         {"fine.frag", "#version 450 core\nvoid main() {}\n"});
    ASSERT_FALSE(program);
    EXPECT_NE(program.error().message.find("broken.vert"), std::string::npos) << program.error().message;
    EXPECT_NE(program.error().message.find("3:     gl_Position = fish;"), std::string::npos) << program.error().message;
}

TEST_F(ProgramTest, defines_reach_the_shader) {
    const Program::Stage vertex{"a.vert", "#version 450 core\nvoid main() { gl_Position = vec4(VALUE); }\n"};
    const Program::Stage fragment{"a.frag", "#version 450 core\nvoid main() {}\n"};
    EXPECT_TRUE(Program::compile(vertex, fragment, "#define VALUE 1.0\n"));
    EXPECT_FALSE(Program::compile(vertex, fragment));
}

TEST_F(ProgramTest, a_shader_that_does_not_exist_is_an_error) {
    EXPECT_FALSE(Program::make("no_such.vert.glsl", "no_such.frag.glsl"));
}

TEST(ShaderSources, have_their_includes_resolved) {
    const std::string_view text = shader_source("near_shaded.vert.glsl");
    EXPECT_TRUE(text.starts_with("#version 450 core"));
    EXPECT_EQ(text.find("#include"), std::string_view::npos);
    EXPECT_NE(text.find("uniform View"), std::string_view::npos);
}

}  // namespace
}  // namespace ff::gl
