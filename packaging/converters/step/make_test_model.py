#!/usr/bin/env python3
"""Writes an AP214 file: an assembly of two instances of one part, a box of 10 x 20 x 30 mm that is blue and has one red face."""
import itertools

CORNERS = list(itertools.product((0, 10), (0, 20), (0, 30)))
# Faces with their outward normals, corners counter-clockwise seen from outside.
FACES = [
    ((-1, 0, 0), (0, 1, 3, 2)),
    ((1, 0, 0), (4, 6, 7, 5)),
    ((0, -1, 0), (0, 4, 5, 1)),
    ((0, 1, 0), (2, 3, 7, 6)),
    ((0, 0, -1), (0, 2, 6, 4)),
    ((0, 0, 1), (1, 5, 7, 3)),
]


class File:
    def __init__(self):
        self.lines = []

    def add(self, text):
        self.lines.append(text)
        return f"#{len(self.lines)}"

    def point(self, p):
        return self.add(f"CARTESIAN_POINT('',({p[0]:.1f},{p[1]:.1f},{p[2]:.1f}))")

    def direction(self, d):
        return self.add(f"DIRECTION('',({d[0]:.1f},{d[1]:.1f},{d[2]:.1f}))")

    def placement(self, at, z=(0, 0, 1), x=(1, 0, 0)):
        return self.add(f"AXIS2_PLACEMENT_3D('',{self.point(at)},{self.direction(z)},{self.direction(x)})")

    def product(self, name, product_context, definition_context):
        product = self.add(f"PRODUCT('{name}','{name}','',({product_context}))")
        formation = self.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
        definition = self.add(f"PRODUCT_DEFINITION('design','',{formation},{definition_context})")
        return definition, self.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")

    def box(self):
        """The solid, and its faces."""
        vertices = [self.add(f"VERTEX_POINT('',{self.point(c)})") for c in CORNERS]
        edges = {}

        def edge(a, b):
            low, high = min(a, b), max(a, b)
            if (low, high) not in edges:
                along = [q - p for p, q in zip(CORNERS[low], CORNERS[high])]
                length = max(along)
                way = self.direction([c / length for c in along])
                line = self.add(f"LINE('',{self.point(CORNERS[low])},{self.add(f'VECTOR({chr(39) * 2},{way},{length:.1f})')})")
                edges[low, high] = self.add(f"EDGE_CURVE('',{vertices[low]},{vertices[high]},{line},.T.)")
            return self.add(f"ORIENTED_EDGE('',*,*,{edges[low, high]},{'.T.' if a < b else '.F.'})")

        faces = []
        for normal, corners in FACES:
            around = ",".join(edge(a, b) for a, b in zip(corners, corners[1:] + corners[:1]))
            bound = self.add(f"FACE_OUTER_BOUND('',{self.add(f'EDGE_LOOP({chr(39) * 2},({around}))')},.T.)")
            across = (0, 1, 0) if normal[0] else (1, 0, 0)
            plane = self.add(f"PLANE('',{self.placement(CORNERS[corners[0]], normal, across)})")
            faces.append(self.add(f"ADVANCED_FACE('',({bound}),{plane},.T.)"))
        shell = self.add(f"CLOSED_SHELL('',({','.join(faces)}))")
        return self.add(f"MANIFOLD_SOLID_BREP('box',{shell})"), faces

    def styled(self, item, rgb):
        colour = self.add(f"COLOUR_RGB('',{rgb[0]:.1f},{rgb[1]:.1f},{rgb[2]:.1f})")
        fill = self.add(f"FILL_AREA_STYLE('',({self.add(f'FILL_AREA_STYLE_COLOUR({chr(39) * 2},{colour})')}))")
        side = self.add(f"SURFACE_SIDE_STYLE('',({self.add(f'SURFACE_STYLE_FILL_AREA({fill})')}))")
        style = self.add(f"PRESENTATION_STYLE_ASSIGNMENT(({self.add(f'SURFACE_STYLE_USAGE(.BOTH.,{side})')}))")
        return self.add(f"STYLED_ITEM('',({style}),{item})")


def main():
    f = File()
    context = f.add("APPLICATION_CONTEXT('core data for automotive mechanical design processes')")
    f.add(f"APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,{context})")
    product_context = f.add(f"PRODUCT_CONTEXT('',{context},'mechanical')")
    definition_context = f.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{context},'design')")
    length = f.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
    angle = f.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    solid_angle = f.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    near = f.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),{length},'distance_accuracy_value','')")
    space = f.add(
        f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({near}))"
        f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))REPRESENTATION_CONTEXT('',''))"
    )
    part, part_shape = f.product("Box", product_context, definition_context)
    solid, faces = f.box()
    origin = f.placement((0, 0, 0))
    part_rep = f.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION('',({origin},{solid}),{space})")
    f.add(f"SHAPE_DEFINITION_REPRESENTATION({part_shape},{part_rep})")
    styles = f"{f.styled(solid, (0, 0, 1))},{f.styled(faces[5], (1, 0, 0))}"
    f.add(f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',({styles}),{space})")
    whole, whole_shape = f.product("Pair \\X2\\00E4\\X0\\", product_context, definition_context)
    places = [f.placement((0, 0, 0)), f.placement((0, 0, 0)), f.placement((50, 0, 0))]
    whole_rep = f.add(f"SHAPE_REPRESENTATION('',({','.join(places)}),{space})")
    f.add(f"SHAPE_DEFINITION_REPRESENTATION({whole_shape},{whole_rep})")
    for k, place in enumerate(places[1:]):
        name = ("Left", "Right")[k]
        usage = f.add(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{k + 1}','{name}','',{whole},{part},$)")
        usage_shape = f.add(f"PRODUCT_DEFINITION_SHAPE('Placement','',{usage})")
        transform = f.add(f"ITEM_DEFINED_TRANSFORMATION('','',{origin},{place})")
        relation = f.add(
            f"(REPRESENTATION_RELATIONSHIP('','',{part_rep},{whole_rep})"
            f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({transform})SHAPE_REPRESENTATION_RELATIONSHIP())"
        )
        f.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{usage_shape})")
    print("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');")
    print("FILE_NAME('pair.step','2020-01-01T00:00:00',(''),(''),'','','');")
    print("FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;")
    for k, line in enumerate(f.lines):
        print(f"#{k + 1}={line};")
    print("ENDSEC;\nEND-ISO-10303-21;")


main()
