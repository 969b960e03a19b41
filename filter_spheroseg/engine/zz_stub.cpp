#include "segment.h"
namespace spheroseg{
PreparedMesh::PreparedMesh(TriangleMesh m,int t):mesh_(std::move(m)),dual_graph_(build_dual_graph(mesh_,t)),report_(inspect(mesh_,dual_graph_,t)){}
const Parametrization& PreparedMesh::parametrization(int,const Progress&){ if(!parametrization_){ parametrization_=Parametrization{mesh_.positions}; for(auto&p:parametrization_->positions) p=p*(1/length(p));} return *parametrization_;}
bool PreparedMesh::set_parametrization(std::vector<Vec3> p){ parametrization_=Parametrization{p}; return true;}
int requested_submesh_count(const SegmentOptions&o,int f){ return o.triangles_per_submesh>0?(f+o.triangles_per_submesh-1)/o.triangles_per_submesh:o.submesh_count>0?o.submesh_count:std::max(1,std::min(200,f/10));}
void validate(const SegmentOptions&o,const PreparedMesh&m){auto e=closed_genus_zero_error(m.report()); if(!e.empty()) throw InvalidInput(e); if(requested_submesh_count(o,m.report().face_count)>m.report().face_count) throw InvalidOptions("too many");}
Segmentation segment(PreparedMesh&m,const SegmentOptions&o,const Progress&p){Segmentation s;int F=m.mesh().face_count();int k=requested_submesh_count(o,F);s.labels.resize(F);for(int i=0;i<F;++i)s.labels[i]=(long long)i*k/F;s.measures=measure(m.mesh(),m.dual_graph(),s.labels,k);report_progress(p,1,"x");return s;}
ParametrizationQuality measure_parametrization(const TriangleMesh&,const std::vector<Vec3>&){return {};}
}
