# SPDX-License-Identifier: Apache-2.0
# Blender 3.4 headless: the built-in monkey primitive as triangulated OBJ, plain and subdivided once.
#   blender -b --factory-startup --python export_suzanne.py -- OUTDIR
import bpy, sys
out = sys.argv[sys.argv.index("--") + 1]
for name, sub in (("suzanne", 0), ("suzanne_subdiv1", 1)):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_monkey_add(size=2.0)
    o = bpy.context.active_object
    if sub:
        m = o.modifiers.new("s", 'SUBSURF'); m.levels = sub; m.render_levels = sub
    m = o.modifiers.new("t", 'TRIANGULATE')
    bpy.ops.wm.obj_export(filepath="%s/%s.obj" % (out, name), export_selected_objects=True, apply_modifiers=True,
                          export_materials=False, export_uv=False, export_normals=True)
