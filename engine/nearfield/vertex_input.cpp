#include "engine/nearfield/vertex_input.h"

#include "engine/nearfield/draw_list.h"

namespace ff::nearfield {

void detail::delete_vertex_array(GLuint id) {
    glDeleteVertexArrays(1, &id);
}

namespace {
enum Stream : GLuint { kPositions = 0, kAttributes = 1, kRecords = 2 };
}

VertexInput VertexInput::make(const GpuScene& gpu) {
    GLuint id = 0;
    glCreateVertexArrays(1, &id);
    const auto attribute = [&](GLuint location, GLuint stream) {
        glEnableVertexArrayAttrib(id, location);
        glVertexArrayAttribBinding(id, location, stream);
    };
    using Attributes = scene::VertexAttributes;
    attribute(0, kPositions);
    glVertexArrayAttribFormat(id, 0, 3, GL_FLOAT, GL_FALSE, 0);
    attribute(1, kAttributes);
    glVertexArrayAttribFormat(id, 1, 2, GL_SHORT, GL_TRUE, offsetof(Attributes, normal_oct));
    attribute(2, kAttributes);
    glVertexArrayAttribFormat(id, 2, 2, GL_FLOAT, GL_FALSE, offsetof(Attributes, uv));
    attribute(3, kAttributes);
    glVertexArrayAttribFormat(id, 3, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Attributes, color));
    for (GLuint row = 0; row < 3; ++row) {
        attribute(4 + row, kRecords);
        glVertexArrayAttribFormat(id, 4 + row, 4, GL_FLOAT, GL_FALSE, 16 * row);
    }
    attribute(7, kRecords);
    glVertexArrayAttribIFormat(id, 7, 3, GL_UNSIGNED_INT, offsetof(InstanceRecord, instance));
    glVertexArrayBindingDivisor(id, kRecords, 1);
    glVertexArrayVertexBuffer(id, kPositions, gpu.positions.id(), 0, sizeof(Vec3));
    glVertexArrayVertexBuffer(id, kAttributes, gpu.attributes.id(), 0, sizeof(Attributes));
    VertexInput input;
    input.object_ = gl::Object<detail::delete_vertex_array>(id);
    return input;
}

void VertexInput::bind(GLuint index_buffer, const gl::StreamBuffer& records) const {
    glVertexArrayElementBuffer(object_.id(), index_buffer);
    glVertexArrayVertexBuffer(object_.id(), kRecords, records.id(), GLintptr(records.offset()), sizeof(InstanceRecord));
    glBindVertexArray(object_.id());
}

}  // namespace ff::nearfield
